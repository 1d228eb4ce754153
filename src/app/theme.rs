//! Colours, type and spacing, in one place, for the dark and the light theme.
//!
//! Colours that carry meaning come from Okabe and Ito's palette (2008), which stays distinct for colour-blind eyes; a word or a mark
//! always says the same.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, Style, TextStyle, Visuals};

use crate::check::Severity;
use crate::render::surfaces::{WORLD_COLOR, numbered_color};
use crate::tracking::Mode;

/// Space between the controls of one group and between groups, in points.
pub const GAP: f32 = 6.0;
/// Space between sections.
pub const SECTION_GAP: f32 = 14.0;
/// Widths of the side panels.
pub const SCENE_PANEL_WIDTH: f32 = 300.0;
pub const RENDER_PANEL_WIDTH: f32 = 280.0;

/// Marks that say in shape what colours say too; the fonts have each of them.
pub const WARNING_MARK: &str = "▲";
pub const ERROR_MARK: &str = "■";
pub const ADVICE_MARK: &str = "◆";
pub const CHECK_MARK: &str = "√";
pub const CLOSE_MARK: &str = "×";
pub const DOT: &str = "●";

/// Text style of section titles.
pub fn section_style() -> TextStyle {
    TextStyle::Name("section".into())
}

/// Text style of numbers in dense tables.
pub fn small_mono_style() -> TextStyle {
    TextStyle::Name("small mono".into())
}

/// What lies over pictures, which are of any brightness: light on a dark ground in both themes.
pub mod over_pictures {
    use egui::Color32;

    pub const GROUND: Color32 = Color32::from_black_alpha(178);
    pub const TEXT: Color32 = Color32::from_rgb(0xf0, 0xf1, 0xf3);
    pub const WEAK: Color32 = Color32::from_rgb(0xc0, 0xc5, 0xcc);
    pub const FINE: Color32 = Color32::from_rgb(0x6f, 0xdc, 0xb0);
    pub const ALERT: Color32 = Color32::from_rgb(0xf5, 0xc0, 0x4a);
}

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// A colour as pictures have it.
pub fn opaque([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Colours of a theme that widgets do not have of their own.
#[derive(Debug, Clone, Copy)]
pub struct Palette {
    pub is_dark: bool,
    /// Behind the picture.
    pub canvas: Color32,
    pub accent: Color32,
    pub warning: Color32,
    pub error: Color32,
    pub good: Color32,
    /// Lines of the tree, borders.
    pub line: Color32,
    pub weak_text: Color32,
}

const DARK: Palette = Palette {
    is_dark: true,
    canvas: rgb(0x0e0f11),
    accent: rgb(0x5ab0f0),
    warning: rgb(0xf0b030),
    error: rgb(0xf48b73),
    good: rgb(0x3fc69a),
    line: rgb(0x3a3e45),
    weak_text: rgb(0xa2a8b0),
};

const LIGHT: Palette = Palette {
    is_dark: false,
    canvas: rgb(0xc9ccd1),
    accent: rgb(0x095fa6),
    warning: rgb(0x835300),
    error: rgb(0xa73800),
    good: rgb(0x006b4b),
    line: rgb(0xc6cad0),
    weak_text: rgb(0x50565f),
};

/// Of the modes in their order, on dark and on light ground; the last are for modes to come.
const MODES: [[u32; 2]; 8] = [
    [0xe69f00, 0x7f5500],
    [0xf28c72, 0xa43b18],
    [0x56b4e9, 0x1a638f],
    [0xd5c94a, 0x655f16],
    [0xb3a2f0, 0x624eac],
    [0x2fc090, 0x006b4b],
    [0xdb91b6, 0x90436e],
    [0x8ea6ff, 0x3a4fc4],
];

impl Palette {
    /// The palette of the theme that `ui` has.
    pub fn of(ui: &egui::Ui) -> Self {
        if ui.visuals().dark_mode { DARK } else { LIGHT }
    }

    /// The palette of the theme that is shown.
    pub fn of_context(ctx: &egui::Context) -> Self {
        if ctx.theme() == egui::Theme::Dark { DARK } else { LIGHT }
    }

    /// The mark of a mode, on labels and in tables.
    pub fn mode(&self, mode: Mode) -> Color32 {
        let [on_dark, on_light] = MODES[mode as usize % MODES.len()];
        rgb(if self.is_dark { on_dark } else { on_light })
    }

    /// The swatch of the medium at `index` in the scene's list.
    pub fn medium(&self, index: usize) -> Color32 {
        opaque(numbered_color(index as u32))
    }

    /// The swatch of the global medium.
    pub fn world(&self) -> Color32 {
        opaque(WORLD_COLOR)
    }

    pub fn severity(&self, severity: Severity) -> Color32 {
        match severity {
            Severity::Error => self.error,
            Severity::Warning => self.warning,
            Severity::Advice => self.accent,
        }
    }
}

/// Puts both themes into the context.
pub fn install(ctx: &egui::Context) {
    let mut fonts = egui::FontDefinitions::default();
    if let Some(family) = fonts.families.get_mut(&FontFamily::Proportional) {
        // Arrows, dots and triangles, which the proportional font lacks.
        family.push("Hack".to_owned());
    }
    ctx.set_fonts(fonts);
    ctx.set_style_of(egui::Theme::Dark, style(true));
    ctx.set_style_of(egui::Theme::Light, style(false));
    // The size of the interface has a setting of its own.
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
}

fn style(is_dark: bool) -> Style {
    use FontFamily::{Monospace, Proportional};
    let mut style = Style { visuals: visuals(is_dark), ..Style::default() };
    style.text_styles = [
        (TextStyle::Heading, FontId::new(16.0, Proportional)),
        (TextStyle::Body, FontId::new(13.0, Proportional)),
        (TextStyle::Button, FontId::new(13.0, Proportional)),
        (TextStyle::Small, FontId::new(11.0, Proportional)),
        (TextStyle::Monospace, FontId::new(12.0, Monospace)),
        (section_style(), FontId::new(11.0, Proportional)),
        (small_mono_style(), FontId::new(11.0, Monospace)),
    ]
    .into();
    style.drag_value_text_style = TextStyle::Monospace;
    let spacing = &mut style.spacing;
    spacing.item_spacing = egui::vec2(GAP, 4.0);
    spacing.button_padding = egui::vec2(8.0, 3.0);
    spacing.interact_size = egui::vec2(36.0, 22.0);
    spacing.slider_rail_height = 4.0;
    spacing.combo_width = 60.0;
    spacing.menu_margin = Margin::same(5);
    spacing.window_margin = Margin::same(14);
    spacing.tooltip_width = 320.0;
    spacing.icon_width = 15.0;
    spacing.scroll = egui::style::ScrollStyle::thin();
    style.interaction.selectable_labels = false;
    style.interaction.tooltip_delay = 0.6;
    style.animation_time = 0.1;
    style
}

fn visuals(is_dark: bool) -> Visuals {
    let mut v = if is_dark { Visuals::dark() } else { Visuals::light() };
    let radius = CornerRadius::same(4);
    // Panel, control, hovered control, pressed control, text, strong text.
    let [panel, raised, control, hover, press, text, strong] = if is_dark {
        [0x1b1d20, 0x232629, 0x2d3136, 0x383d44, 0x24272b, 0xd3d6da, 0xf4f5f6].map(rgb)
    } else {
        [0xf3f4f6, 0xffffff, 0xe2e5e9, 0xd5d9df, 0xc6ccd4, 0x24282d, 0x000000].map(rgb)
    };
    let palette = if is_dark { DARK } else { LIGHT };
    v.panel_fill = panel;
    v.window_fill = raised;
    v.window_stroke = Stroke::new(1.0, palette.line);
    v.window_corner_radius = CornerRadius::same(8);
    v.menu_corner_radius = CornerRadius::same(6);
    let shadow = |down, blur, dark, light| {
        let color = Color32::from_black_alpha(if is_dark { dark } else { light });
        Shadow { offset: [0, down], blur, spread: 0, color }
    };
    v.window_shadow = shadow(8, 28, 140, 50);
    v.popup_shadow = shadow(4, 14, 120, 40);
    v.faint_bg_color = if is_dark { rgb(0x212428) } else { rgb(0xebedf0) };
    v.extreme_bg_color = if is_dark { rgb(0x131517) } else { rgb(0xffffff) };
    v.weak_text_color = Some(palette.weak_text);
    v.warn_fg_color = palette.warning;
    v.error_fg_color = palette.error;
    v.hyperlink_color = palette.accent;
    v.selection.bg_fill = if is_dark { rgb(0x1a3f5e) } else { rgb(0xbcdcf7) };
    v.selection.stroke = Stroke::new(1.0, if is_dark { rgb(0xeaf4fd) } else { rgb(0x06304f) });
    v.slider_trailing_fill = true;
    v.handle_shape = egui::style::HandleShape::Circle;
    v.indent_has_left_vline = false;
    let widgets = &mut v.widgets;
    let all = [
        (&mut widgets.noninteractive, panel, text, Stroke::new(1.0, palette.line)),
        (&mut widgets.inactive, control, text, Stroke::NONE),
        (&mut widgets.hovered, hover, strong, Stroke::NONE),
        (&mut widgets.active, press, strong, Stroke::new(1.0, palette.accent)),
        (&mut widgets.open, hover, strong, Stroke::NONE),
    ];
    for (widget, fill, foreground, border) in all {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = border;
        widget.fg_stroke = Stroke::new(1.0, foreground);
        widget.corner_radius = radius;
        widget.expansion = 0.0;
    }
    // Slider rails and check boxes must stand out from the panel.
    widgets.inactive.bg_fill = if is_dark { rgb(0x434951) } else { rgb(0xc3c8cf) };
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance, WCAG 2.2.
    fn luminance(color: Color32) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }

    /// Contrast ratio, WCAG 2.2: small text needs 4.5.
    fn contrast(a: Color32, b: Color32) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn all_text_can_be_read_on_every_ground() {
        for is_dark in [true, false] {
            let v = visuals(is_dark);
            let palette = if is_dark { DARK } else { LIGHT };
            let grounds = [
                ("panel", v.panel_fill),
                ("window", v.window_fill),
                ("faint", v.faint_bg_color),
                ("field", v.extreme_bg_color),
                ("control", v.widgets.inactive.weak_bg_fill),
                ("hovered", v.widgets.hovered.weak_bg_fill),
                ("selected", v.selection.bg_fill),
            ];
            let mut texts = vec![
                ("text".to_owned(), v.text_color()),
                ("weak text".to_owned(), palette.weak_text),
                ("accent".to_owned(), palette.accent),
                ("warning".to_owned(), palette.warning),
                ("error".to_owned(), palette.error),
                ("good".to_owned(), palette.good),
            ];
            texts.extend(
                MODES.iter().enumerate().map(|(i, hex)| (format!("mode {i}"), rgb(hex[usize::from(!is_dark)]))),
            );
            for (name, color) in &texts {
                for (ground, fill) in grounds {
                    let ratio = contrast(*color, fill);
                    assert!(ratio >= 4.5, "{name} on {ground}, dark {is_dark}: {ratio:.2}");
                }
            }
            assert!(contrast(palette.weak_text, palette.canvas) >= 4.5);
            assert!(contrast(v.selection.stroke.color, v.selection.bg_fill) >= 4.5);
        }
    }

    #[test]
    fn labels_can_be_read_over_black_and_over_white_pictures() {
        use over_pictures::{ALERT, GROUND, TEXT, WEAK};
        let share = f64::from(GROUND.a()) / 255.0;
        for picture in [0.0, 255.0] {
            let ground = Color32::from_gray((picture * (1.0 - share)) as u8);
            for color in [ALERT, TEXT, WEAK] {
                assert!(contrast(color, ground) >= 4.5, "{color:?} on {ground:?}");
            }
        }
    }
}

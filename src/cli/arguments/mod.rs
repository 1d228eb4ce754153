//! What can be said on the command line, and what each word means.

mod commands;
mod image;
mod values;
mod window;

use clap::{Parser, Subcommand};

pub use self::commands::{
    CheckArguments, ConvertArguments, ExportArguments, ListArguments, RectifyArguments, ReportArguments, TraceArguments,
};
pub use self::image::{CompareArguments, ImageArguments, MergeArguments, RenderArguments};
pub use self::values::{Granularity, Size, Switch};
pub use self::window::WindowArguments;

const EXAMPLES: &str = "\
Examples:
  iorect                                        open the window on a built-in scene
  iorect my-scene.toml                          open the window on your own
  iorect table.glb                              or on a glTF file
  iorect scenes                                 list the built-in scenes
  iorect compare camera-in-water                naive, stack and rectified side by side, as a PNG
  iorect render nested-spheres --spp 256 -o out.exr
  iorect merge part*.exr -o all.exr             parts that `render --samples A..B` wrote, as one
  iorect rectify nested-spheres                 what lies on the other side of every surface
  iorect trace camera-in-water --pixel 256,256  one path, vertex by vertex
  iorect check my-scene.toml                    what is wrong or doubtful in a scene
  iorect check scene.xml --deny warning         a linter for scenes of other renderers
  iorect report -o report --quick               error against time, stability, speed, growth: a page

Exit codes: 0 fine, 1 the work failed, 2 the command or the scene was wrong.";

/// Scenes in which dielectrics sit inside dielectrics: seen, compared, measured.
///
/// Without a command, opens the window. Wherever a SCENE is asked for, the path of a scene file, a glTF, Mitsuba or pbrt file or a mesh,
/// or the name of a built-in scene will do.
#[derive(Debug, Parser)]
#[command(name = "iorect", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES, max_term_width = 110)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub window: WindowArguments,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render one image in one mode, to PNG or EXR
    Render(RenderArguments),
    /// Render several modes side by side, with labels and differences, in one PNG
    Compare(CompareArguments),
    /// Put together parts of an image that were rendered apart, without rounding
    Merge(MergeArguments),
    /// Show what rectification found on the other side of every refractor
    Rectify(RectifyArguments),
    /// Follow one path, vertex by vertex
    Trace(TraceArguments),
    /// Say what is wrong or doubtful in a scene, with advice
    Check(CheckArguments),
    /// Write a glTF, Mitsuba or pbrt file, a scene around a mesh, or a built-in scene as a scene file
    Convert(ConvertArguments),
    /// List the built-in scenes
    Scenes(ListArguments),
    /// Measure scenes: error against run time, stability, what was left out, growth, as a page with plots and tables
    Report(ReportArguments),
    /// Write a scene for another renderer, every interface resolved
    Export(ExportArguments),
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Arguments::command().debug_assert();
    }
}

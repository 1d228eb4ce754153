//! Opening, saving and exporting, on threads of their own: the window never waits for a disk or a dialog.

use std::future::Future;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use image::RgbImage;

use super::autosave::Found;
use super::background::Repaint;
use super::command::{Command, ExportKind};
use super::develop::Source;
use super::measurement::GivenImage;
use super::opening::Reading;
use crate::export::{self, Comparison, ExportError, LabelledPane, Picture};
use crate::formats::{MESH_ENDINGS, disk};
use crate::optics::Medium;
use crate::render::Display;
use crate::render::slice::Slice;
use crate::scene::description::Object;
use crate::scene::environment::EnvironmentImage;
use crate::scene::texture::TextureImage;
use crate::scene::{Description, SceneError};
use crate::session::Snapshot;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};
use crate::writing::write_atomically;

/// Least time that a dialog stays open; a faster answer means that none was shown.
const NO_DIALOG: Duration = Duration::from_millis(1000);

/// What a path is wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Open,
    SaveAs,
    /// An image that surrounds the scene.
    Environment,
    /// An image on a solid.
    Texture,
    Mesh,
    /// An image that panes are measured against.
    Reference,
    Export(ExportKind),
}

impl Purpose {
    /// Title of the dialog.
    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a scene",
            Self::SaveAs => "Save the scene as",
            Self::Mesh => "Add a mesh",
            Self::Reference => "Choose an image to measure against",
            Self::Export(ExportKind::ShownPane) => "Export the active pane as it is shown",
            Self::Export(ExportKind::ShownPanes) => "Export all panes as they are shown",
            Self::Export(ExportKind::PanePng) => "Export the picture of the active pane",
            Self::Export(ExportKind::AllPanesPng) => "Export a comparison sheet",
            Self::Export(ExportKind::PaneExr) => "Export the active pane as linear EXR",
            Self::Environment => "Choose an image that surrounds the scene",
            Self::Texture => "Choose an image for the surface",
            Self::Export(ExportKind::ErrorsCsv) => "Export the measured errors as CSV",
            Self::Export(ExportKind::PathSvg) => "Export the path as SVG",
            Self::Export(ExportKind::PathJson) => "Export the path as JSON",
        }
    }

    /// What the dialog offers, and the endings that such files have.
    fn filter(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Open => {
                ("scenes and meshes", &["toml", "glb", "gltf", "xml", "pbrt", "obj", "ply", "stl", "serialized"])
            }
            Self::SaveAs => ("iorect scenes", &["toml"]),
            Self::Environment => ("images", &["exr", "hdr", "png", "jpg", "jpeg"]),
            Self::Texture => ("images", &["png", "jpg", "jpeg", "exr", "hdr"]),
            Self::Mesh => ("meshes", MESH_ENDINGS),
            Self::Reference => ("linear images", &["exr", "hdr"]),
            Self::Export(ExportKind::PaneExr) => ("OpenEXR", &["exr"]),
            Self::Export(ExportKind::ErrorsCsv) => ("CSV", &["csv"]),
            Self::Export(ExportKind::PathSvg) => ("SVG", &["svg"]),
            Self::Export(ExportKind::PathJson) => ("JSON", &["json"]),
            Self::Export(_) => ("PNG", &["png"]),
        }
    }

    pub fn endings(self) -> &'static [&'static str] {
        self.filter().1
    }

    pub fn extension(self) -> &'static str {
        self.endings()[0]
    }

    /// Whether the file is read, and not written.
    pub fn is_reading(self) -> bool {
        matches!(self, Self::Open | Self::Environment | Self::Texture | Self::Mesh | Self::Reference)
    }

    /// The path with the extension where the user typed none.
    pub fn extended(self, path: &Path) -> PathBuf {
        let is_whole = self.is_reading() || path.extension().is_some();
        if is_whole { path.to_owned() } else { path.with_extension(self.extension()) }
    }

    /// What is to be done with a chosen path, after a question if there is such a file.
    pub fn command(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::Open(path),
            Self::SaveAs => Command::SaveAs(path),
            Self::Environment => Command::ReadEnvironment(path),
            Self::Texture => Command::ReadTexture(path),
            Self::Mesh => Command::ReadMesh(path),
            Self::Reference => Command::ReadReferenceImage(path),
            Self::Export(kind) => Command::Export(kind, path),
        }
    }

    /// [`Self::command`] without the question.
    pub fn command_anyway(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::Open(path),
            Self::SaveAs => Command::SaveAsAnyway(path),
            Self::Environment => Command::ReadEnvironment(path),
            Self::Texture => Command::ReadTexture(path),
            Self::Mesh => Command::ReadMesh(path),
            Self::Reference => Command::ReadReferenceImage(path),
            Self::Export(kind) => Command::ExportAnyway(kind, path),
        }
    }

    /// Asks for a path.
    pub fn question(self) -> Command {
        match self {
            Self::Open => Command::AskOpen,
            Self::SaveAs => Command::AskSaveAs,
            Self::Environment => Command::AskEnvironmentImage,
            Self::Texture => Command::AskTexture,
            Self::Mesh => Command::AskMesh,
            Self::Reference => Command::AskReferenceImage,
            Self::Export(kind) => Command::AskExport(kind),
        }
    }
}

/// What came of a request.
pub enum Outcome {
    /// A path from the system's dialog, which has asked about a file of that name.
    Chosen(Purpose, PathBuf),
    /// A path about which nobody has asked yet.
    ChosenUnasked(Purpose, PathBuf),
    /// Something would be written over that file.
    IsThere(Purpose, PathBuf),
    /// Nothing would be written over.
    IsFree(Purpose, PathBuf),
    /// This system shows no dialogs: ask in the window.
    NoDialog(Purpose, PathBuf),
    /// What was asked for under that number; from an autosave, if there is one.
    Opened(u64, Box<Description>, Option<Found>),
    /// In words for the user.
    NotOpened(u64, String),
    /// An image to surround the scene, and its file.
    EnvironmentRead(PathBuf, EnvironmentImage),
    /// An image that panes are to be measured against.
    ReferenceRead(Arc<GivenImage>),
    /// An image for the solid of that name, and its file.
    TextureRead(String, PathBuf, TextureImage),
    /// The scene in the file at that path, which another program has changed.
    Reloaded(PathBuf, Result<Box<Description>, String>),
    /// The objects of a mesh that is to be added, with their media.
    Mesh(Vec<(Object, Option<Medium>)>),
    Saved(PathBuf, Arc<Description>),
    Exported(PathBuf),
    /// In words for the user.
    Failed(String),
}

/// Everything needed to write pictures.
#[derive(Clone)]
pub struct ExportJob {
    pub kind: ExportKind,
    pub path: PathBuf,
    pub prepared: Prepared,
    pub display: Display,
    pub seed: u64,
    /// What the panes are made from: the active one alone, or all.
    pub panes: Vec<Source>,
}

/// Starts jobs and collects what came of them.
pub struct Files {
    sender: Sender<Outcome>,
    receiver: Receiver<Outcome>,
    wake: Repaint,
    /// Where files are proposed, by a question in the window; `None`: the system has a dialog for that, and knows.
    prompts_in: Option<PathBuf>,
}

impl Files {
    pub fn new(wake: Repaint) -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver, wake, prompts_in: None }
    }

    /// Paths are asked for in the window from now on, and proposed in `folder`.
    pub fn prompt_in(&mut self, folder: PathBuf) {
        self.prompts_in = Some(folder);
    }

    /// The next thing that has come of a job.
    pub fn poll(&self) -> Option<Outcome> {
        self.receiver.try_recv().ok()
    }

    fn spawn(&self, job: impl FnOnce() -> Option<Outcome> + Send + 'static) {
        let (sender, wake) = (self.sender.clone(), Arc::clone(&self.wake));
        let spawned = std::thread::Builder::new().name("files".into()).spawn(move || {
            if let Some(outcome) = job() {
                // The window may be gone by now, and then nobody wants to know.
                let _ = sender.send(outcome);
                wake();
            }
        });
        if let Err(error) = spawned {
            let _ = self.sender.send(Outcome::Failed(format!("Cannot start a thread: {error}")));
        }
    }

    fn attempt<E: ToString>(&self, job: impl FnOnce() -> Result<Outcome, E> + Send + 'static) {
        self.spawn(move || Some(job().unwrap_or_else(|error| Outcome::Failed(error.to_string()))));
    }

    /// Asks for a path with the system's dialog.
    pub fn ask(&self, purpose: Purpose, suggestion: &Path) {
        if let Some(folder) = &self.prompts_in {
            let proposed = folder.join(suggestion.file_name().unwrap_or_default());
            return self.spawn(move || Some(Outcome::NoDialog(purpose, proposed)));
        }
        let (name, extensions) = purpose.filter();
        let mut dialog = rfd::AsyncFileDialog::new().set_title(purpose.title()).add_filter(name, extensions);
        if let Some(folder) = suggestion.parent().filter(|folder| folder.is_dir()) {
            dialog = dialog.set_directory(folder);
        }
        let file_name = suggestion.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let suggestion = suggestion.to_owned();
        let start = Instant::now();
        // The future is made here because some systems want dialogs to be asked for from the main thread.
        let chosen: std::pin::Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>> = match purpose {
            _ if purpose.is_reading() => Box::pin(dialog.pick_file()),
            _ => Box::pin(dialog.set_file_name(file_name).save_file()),
        };
        self.spawn(move || match pollster::block_on(chosen) {
            Some(file) => Some(outcome_of(purpose, file.path())),
            None if start.elapsed() < NO_DIALOG => Some(Outcome::NoDialog(purpose, suggestion)),
            None => None,
        });
    }

    /// Reads a scene by path or built-in name; `id` comes back with it.
    pub fn open(&self, id: u64, name_or_path: PathBuf) {
        self.spawn(move || Some(opened(id, crate::formats::open(&name_or_path))));
    }

    /// Reads an image that is to surround the scene.
    pub fn read_environment(&self, path: PathBuf) {
        self.attempt(move || {
            let told = |message: String| format!("The image {} cannot be used: {message}", path.display());
            let bytes = disk::read(&path, disk::MAX_DATA_BYTES).map_err(|error| told(error.to_string()))?;
            let image = crate::formats::image_from_bytes(&bytes, &path).map_err(told)?;
            Ok::<_, String>(Outcome::EnvironmentRead(path, image))
        });
    }

    /// Reads an image that panes are to be measured against.
    pub fn read_reference(&self, path: PathBuf) {
        self.attempt(move || GivenImage::read(&path).map(|image| Outcome::ReferenceRead(Arc::new(image))));
    }

    /// Reads an image that is to be on a solid.
    pub fn read_texture(&self, object: String, path: PathBuf) {
        self.attempt(move || {
            let told = |message: String| format!("The image {} cannot be used: it {message}", path.display());
            let bytes = disk::read(&path, disk::MAX_DATA_BYTES).map_err(|error| told(error.to_string()))?;
            let image = crate::formats::texture::decode(&bytes).map_err(told)?;
            Ok::<_, String>(Outcome::TextureRead(object, path, image))
        });
    }

    /// Reads a scene's file again.
    pub fn reload(&self, path: PathBuf) {
        self.spawn(move || {
            let read = crate::formats::file(&path).map(Box::new).map_err(|error| error.to_string());
            Some(Outcome::Reloaded(path, read))
        });
    }

    /// Goes on with a scene that is being read already.
    pub fn finish(&self, id: u64, reading: Reading) {
        self.spawn(move || Some(opened(id, reading.wait())));
    }

    /// Reads a mesh that the scene is to name as `written`.
    pub fn read_mesh(&self, path: PathBuf, written: PathBuf) {
        self.attempt(move || crate::formats::mesh_objects_from_file(&path, &written).map(Outcome::Mesh));
    }

    /// Reads what an earlier instance left behind.
    pub fn restore(&self, id: u64, found: Found) {
        self.spawn(move || {
            Some(match found.description() {
                Ok(description) => Outcome::Opened(id, Box::new(description), Some(found)),
                Err(error) => {
                    let kept = found.slot.path().display();
                    Outcome::NotOpened(id, format!("{error}\nThe edits stay in {kept}."))
                }
            })
        });
    }

    /// Removes what an earlier instance left behind.
    pub fn discard(&self, found: Found) {
        self.spawn(move || {
            found.slot.remove();
            None
        });
    }

    pub fn save(&self, description: Arc<Description>, path: PathBuf) {
        self.attempt(move || crate::formats::save(&description, &path).map(|()| Outcome::Saved(path, description)));
    }

    pub fn export(&self, job: ExportJob) {
        self.attempt(move || write_pictures(&job).map(|()| Outcome::Exported(job.path)));
    }

    /// Finds out whether something would be written over.
    pub fn look(&self, purpose: Purpose, path: PathBuf) {
        self.spawn(move || {
            let is_there = std::fs::metadata(&path).is_ok_and(|known| known.is_file());
            Some(if is_there { Outcome::IsThere(purpose, path) } else { Outcome::IsFree(purpose, path) })
        });
    }

    /// Writes an image that is encoded already, with `text` in its chunks.
    pub fn export_image(&self, image: RgbImage, text: Vec<(String, String)>, path: PathBuf) {
        self.attempt(move || export::image_png(&path, &image, &text).map(|()| Outcome::Exported(path)));
    }

    pub fn export_text(&self, text: String, path: PathBuf) {
        let write = |path: &Path, text: &str| write_atomically(path, |file| file.write_all(text.as_bytes()));
        self.attempt(move || write(&path, &text).map(|()| Outcome::Exported(path)));
    }
}

/// What came of the system's dialog. It knows nothing of a file whose name it was not told whole.
fn outcome_of(purpose: Purpose, path: &Path) -> Outcome {
    let extended = purpose.extended(path);
    if extended == path { Outcome::Chosen(purpose, extended) } else { Outcome::ChosenUnasked(purpose, extended) }
}

fn opened(id: u64, read: Result<Description, SceneError>) -> Outcome {
    match read {
        Ok(description) => Outcome::Opened(id, Box::new(description), None),
        Err(error) => Outcome::NotOpened(id, error.to_string()),
    }
}

fn picture_of(film: &Snapshot) -> Picture {
    Picture { width: film.size[0], height: film.size[1], rgb: film.rgb.clone() }
}

fn write_pictures(job: &ExportJob) -> Result<(), ExportError> {
    // Each mode once, in the order of the panes: a difference is told by the modes that it is made of.
    let mut films: Vec<&Arc<Snapshot>> = Vec::new();
    for film in job.panes.iter().flat_map(|source| &source.films) {
        if films.iter().all(|known| known.mode != film.mode) {
            films.push(film);
        }
    }
    // After them what was kept.
    let live = films.len();
    for kept in job.panes.iter().flat_map(|source| &source.kept) {
        if films[live..].iter().all(|known| !Arc::ptr_eq(known, &kept.film)) {
            films.push(&kept.film);
        }
    }
    let truth = job.panes.iter().find_map(|source| source.truth.as_ref());
    let paintings: Vec<_> = (job.panes.iter().filter_map(|source| source.painted.as_ref()))
        .map(|painted| (painted.quantity, &painted.painting))
        .collect();
    let slices: Vec<&Slice> = job.panes.iter().filter_map(|source| Some(&source.slice.as_ref()?.slice)).collect();
    let painted = || {
        let sheets = [export::painted_surfaces(&job.prepared, &paintings), export::slices(&job.prepared, &slices)];
        sheets.into_iter().reduce(|above, under| below(above, &under)).unwrap_or_default()
    };
    let Some(first) = films.first() else {
        return match job.kind {
            _ if paintings.is_empty() && slices.is_empty() => {
                Err(ExportError::BadComparison("there is no image yet; wait for the first one".into()))
            }
            ExportKind::PaneExr => Err(ExportError::BadComparison(
                "painted surfaces and slices are colours and no radiance: export them as PNG".into(),
            )),
            _ => {
                let rays = paintings.first().map_or(1, |(_, painting)| painting.rays);
                let text = export::metadata(&job.prepared, &[], rays, job.seed);
                export::image_png(&job.path, &painted(), &text)
            }
        };
    };
    let modes: Vec<Mode> = films.iter().map(|film| film.mode).collect();
    let samples = films.iter().map(|film| film.samples).min().unwrap_or(0);
    let mut text = export::metadata(&job.prepared, &modes, samples, job.seed);
    text.push(export::estimator(first.estimator));
    match job.kind {
        ExportKind::PaneExr => export::exr(&job.path, &picture_of(first), &text),
        ExportKind::PanePng if films.len() == 1 && truth.is_none() => {
            export::png(&job.path, &picture_of(first), &job.display, &text)
        }
        _ => {
            let pictures: Vec<Picture> = films.iter().map(|film| picture_of(film)).collect();
            let mut panes: Vec<LabelledPane<'_>> = (films.iter().zip(&pictures))
                .enumerate()
                .map(|(index, (film, picture))| LabelledPane {
                    title: if index < live { film.mode.name().to_owned() } else { format!("{}, kept", film.mode) },
                    details: format!("{} spp · {:.1} s", film.samples, film.seconds),
                    events: film.events,
                    picture,
                })
                .collect();
            // The mode nearest to the truth is what the others are held against, or the truth itself.
            let candidates = if live > 0 { live } else { modes.len() };
            let mut best =
                modes[..candidates].iter().enumerate().max_by_key(|(_, mode)| **mode).map(|(index, _)| index);
            let truth_picture = truth.map(|truth| {
                let [width, height] = truth.size;
                let details = truth.file.clone().unwrap_or_else(|| format!("2 × {} spp", truth.samples));
                (Picture { width, height, rgb: truth.mean.clone() }, details)
            });
            if let Some((picture, details)) = &truth_picture {
                best = Some(panes.len());
                panes.push(LabelledPane {
                    title: "reference image".to_owned(),
                    details: details.clone(),
                    events: Events::default(),
                    picture,
                });
            }
            let about = Comparison {
                title: job.prepared.description.name.clone(),
                details: format!("{} × {}", first.size[0], first.size[1]),
                display: job.display,
                baseline: best.filter(|_| panes.len() > 1),
            };
            let comparison = export::comparison(&panes, &about)?;
            export::image_png(&job.path, &below(comparison, &painted()), &text)
        }
    }
}

/// One sheet under the other.
fn below(above: RgbImage, under: &RgbImage) -> RgbImage {
    if under.width() == 0 {
        return above;
    }
    if above.width() == 0 {
        return under.clone();
    }
    let ground = *above.get_pixel(0, 0);
    let (width, height) = (above.width().max(under.width()), above.height() + under.height());
    let mut sheet = RgbImage::from_pixel(width, height, ground);
    image::imageops::replace(&mut sheet, &above, 0, 0);
    image::imageops::replace(&mut sheet, under, 0, i64::from(above.height()));
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::SCENE_ENDINGS;

    #[test]
    fn all_that_opens_is_offered() {
        let mut offered = Purpose::Open.endings().to_vec();
        let mut opens = [SCENE_ENDINGS, MESH_ENDINGS].concat();
        offered.sort_unstable();
        opens.sort_unstable();
        opens.dedup();
        assert_eq!(offered, opens);
    }

    #[test]
    fn extensions_are_added_where_there_is_none() {
        let export = Purpose::Export(ExportKind::PanePng);
        assert_eq!(export.extended(Path::new("a/b")), Path::new("a/b.png"));
        assert_eq!(export.extended(Path::new("a/b.x")), Path::new("a/b.x"));
        assert_eq!(Purpose::Open.extended(Path::new("scene")), Path::new("scene"));
    }

    #[test]
    fn a_name_that_the_system_has_not_seen_whole_is_asked_about() {
        let export = Purpose::Export(ExportKind::ShownPane);
        assert!(
            matches!(outcome_of(export, Path::new("a/b")), Outcome::ChosenUnasked(_, path) if path == Path::new("a/b.png"))
        );
        assert!(
            matches!(outcome_of(export, Path::new("a/b.png")), Outcome::Chosen(_, path) if path == Path::new("a/b.png"))
        );
        assert!(matches!(outcome_of(Purpose::Open, Path::new("a")), Outcome::Chosen(..)));
    }
}

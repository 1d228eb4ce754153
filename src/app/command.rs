//! Everything that a user can do, as data. Panels, menus and shortcuts return commands; [`super::state`] and [`super::files`] apply
//! them.

use std::path::PathBuf;

use super::build::Addition;
use super::edit::{Edit, MediumEdit, ObjectEdit};
use super::measurement::{ErrorAxis, ErrorMetric, Given};
use super::objects::Manipulation;
use super::range::DifferenceRange;
use super::settings::{Arrangement, DifferenceKind, InterfaceScale, PaneContent, Preset, Tab, Theme};
use super::slice::SliceView;
use super::snapshots::SnapshotId;
use super::state::{PathOption, WorldPart};
use crate::check::Spot;
use crate::optics::Ior;
use crate::render::{BackendChoice, EstimatorChoice, ToneCurve};
use crate::scene::description::CameraDescription;
use crate::session::GroundTruthDemand;
use crate::transport::inspect::Follow;

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum MediumRef {
    /// The global medium.
    World,
    Named(String),
}

impl MediumRef {
    /// On the screen.
    pub fn name(&self) -> &str {
        match self {
            Self::World => "world",
            Self::Named(name) => name,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportKind {
    /// The active pane exactly as the window shows it: range, legend, labels and zoom included.
    ShownPane,
    /// All panes exactly as the window shows them.
    ShownPanes,
    /// The active pane's film at its own size, developed, with nothing over it.
    PanePng,
    /// A sheet with every film, labelled, and differences measured.
    AllPanesPng,
    /// The active pane's linear radiance.
    PaneExr,
    /// The measured points.
    ErrorsCsv,
    /// The inspected path as it lies over the active pane.
    PathSvg,
    /// The same, vertex by vertex.
    PathJson,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    // The scene. Undoable.
    Edit(Edit),
    /// A drag begins: what comes until its end is undone as one.
    BeginDrag,
    /// [`Self::Edit`] as part of a drag; nothing once the drag has been given up.
    Drag(Edit),
    EndDrag,
    Undo,
    Redo,

    /// Adds an object where the camera looks, and selects it.
    Add(Addition),
    AskMesh,
    /// Adds a refractor with the mesh in the file at that path.
    ReadMesh(PathBuf),
    /// Turns the name of the object of that name into a field to type in; `None` puts it away.
    Rename(Option<String>),

    // The view.
    SetCamera(CameraDescription),
    ResetCamera,
    /// Moves the camera, without turning it, so that an object fills a good part of the picture.
    FrameObject(String),
    /// Selects the first object and moves the camera, without turning it, to the place, or to the objects where there is none.
    ShowProblem {
        objects: Vec<String>,
        spot: Option<Spot>,
    },
    /// Back to the view before the last jump of the camera.
    EarlierView,
    SetPaneCount(usize),
    SetPaneContent(usize, PaneContent),
    /// Four panes that answer one question.
    SetPreset(Preset),
    SetActivePane(usize),
    SetArrangement(Arrangement),
    SetDivider([f32; 2]),
    /// Magnification and the point, in [0, 1]² of the film, that is in the middle.
    SetZoom(f32, [f32; 2]),
    /// A pixel of the full-size film, in [0, 1]²; `None` puts the inspector away.
    Inspect(Option<[f64; 2]>),
    /// Turns the camera towards what is seen at a point in [0, 1]² of the film, and orbits around it from now on.
    LookAt([f64; 2]),
    /// Selects the object that is seen at a point in [0, 1]² of the film; again at the same place, the next one behind it.
    SelectAt([f64; 2]),
    /// What can be dragged on the selected object in the picture.
    SetHandles(Option<Manipulation>),
    /// How the inspector goes on at interfaces.
    SetFollow(Follow),
    /// How the inspected path is shown.
    SetPathOption(PathOption),
    /// Follows the light of the light of that name, instead of the marked pixel's path.
    SetPathLight(Option<String>),
    /// Points out a vertex of the inspected path, by index.
    SelectVertex(Option<usize>),
    /// Where the slice lies that panes show.
    SetSlice(SliceView),

    // Rendering and display.
    SetExposure(f32),
    SetCurve(ToneCurve),
    SetDifference(DifferenceKind),
    SetDifferenceRange(DifferenceRange),
    ToggleValues,
    ToggleHistogram,
    /// Keeps the active pane's picture.
    KeepSnapshot(SnapshotId),
    /// Drops a picture that was kept; panes that show it show a mode.
    DropSnapshot(SnapshotId),
    SetResolutionScale(f32),
    SetMaxDepth(Option<u32>),
    SetSampleLimit(Option<u32>),
    /// Mean relative error of a pixel at which rendering stops.
    SetNoiseTarget(Option<f64>),
    SetDenoise(bool),
    /// What renders.
    SetEstimator(EstimatorChoice),
    SetBackend(BackendChoice),
    TogglePause,
    Restart,
    /// Gives up preparing the scene, and goes back to the last one that was prepared.
    CancelPreparation,

    // Measuring.
    /// Begins to make a ground truth, goes on, pauses, or drops it.
    SetGroundTruth(GroundTruthDemand),
    AskReferenceImage,
    /// Reads an image from a file, to measure against it instead of a ground truth.
    ReadReferenceImage(PathBuf),
    /// Measures against an image instead of a ground truth; with `None`, lets it go.
    SetReferenceImage(Given),
    SetErrorMetric(ErrorMetric),
    SetErrorAxis(ErrorAxis),

    // Files.
    /// An empty, lit scene.
    New,
    /// [`Self::New`] even though there are unsaved changes.
    NewAnyway,
    AskOpen,
    /// A path or the name of a built-in scene.
    Open(PathBuf),
    /// [`Self::Open`] even though there are unsaved changes.
    OpenAnyway(PathBuf),
    Save,
    /// [`Self::Save`] even though the file has changed on disk.
    SaveAnyway,
    /// Shows the scene as its file says now.
    LoadChanged,
    /// Leaves the scene as it is although its file has changed.
    KeepMine,
    AskSaveAs,
    /// Asks first if there is such a file.
    SaveAs(PathBuf),
    /// [`Self::SaveAs`] even though there is such a file.
    SaveAsAnyway(PathBuf),
    AskExport(ExportKind),
    /// Asks first if there is such a file.
    Export(ExportKind, PathBuf),
    /// [`Self::Export`] even though there is such a file.
    ExportAnyway(ExportKind, PathBuf),
    /// What the panes show, as linear radiance, to tev.
    SendToTev,
    /// Whether tev is kept up to date.
    ToggleTevLive,
    AskTevAddress,
    /// `HOST:PORT`; empty for the usual one.
    SetTevAddress(String),
    /// The active pane as the window shows it, to the clipboard.
    CopyPane,
    /// All panes as the window shows them, to the clipboard.
    CopyPanes,
    /// The values of the pixel under the pointer, or else of the inspected one, as text to the clipboard.
    CopyValues,
    ClearRecent,
    AskEnvironmentImage,
    /// Asks for an image for the selected solid.
    AskTexture,
    /// Puts the image of that file on the solid that it was asked for.
    ReadTexture(PathBuf),
    /// Puts the image of that file around the scene.
    ReadEnvironment(PathBuf),
    /// Gives up opening a scene.
    CancelOpening,
    /// Opens the autosave at that path, which an earlier instance left behind.
    RestoreEdits(PathBuf),
    /// [`Self::RestoreEdits`] even though there are unsaved changes.
    RestoreEditsAnyway(PathBuf),
    /// Removes the autosave at that path.
    DiscardEdits(PathBuf),
    /// Offers autosaves again at the next start.
    PostponeEdits,
    Quit,
    /// Closes the window even though there are unsaved changes.
    QuitAnyway,

    // The window.
    ToggleScenePanel,
    ToggleRenderPanel,
    ToggleBothPanels,
    ToggleProblems,
    ShowTab(Tab),
    SetTheme(Theme),
    SetInterfaceScale(InterfaceScale),
    /// One step larger (1) or smaller (−1).
    StepInterfaceScale(i32),
    SelectObject(Option<String>),
    SelectWorld(WorldPart),
    /// The next click in a picture puts the focus there, or does not any more.
    PickFocus(bool),
    ShowGallery(bool),
    ShowAdd(bool),
    ShowShortcuts(bool),
    ShowAbout(bool),
    ShowMessages(bool),
    /// A step of the tour, from 0; `None` closes it for good.
    ShowTour(Option<usize>),
    /// Whether built-in scenes choose the panes.
    ToggleFirstPanes,
    DismissNotice(u64),
    /// Closes whatever is on top.
    Escape,
    /// A key that means nothing now.
    Nothing,
}

impl Command {
    /// Another IOR for a medium.
    pub fn set_ior(medium: MediumRef, ior: Ior) -> Self {
        Self::Edit(Edit::Medium(medium, MediumEdit::Ior(ior)))
    }

    /// A change to the object of that name.
    pub fn object(name: impl Into<String>, edit: ObjectEdit) -> Self {
        Self::Edit(Edit::Object(name.into(), edit))
    }
}

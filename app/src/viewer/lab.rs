//! The fit under examination: how it is drawn, edited by hand, and compared with other objectives.
//!
//! While a value is dragged, only the Fit stage is asked for, and never a second time before the first has answered;
//! the whole pipeline follows when the value is let go. The drag is one step of undo.

use endcomfort_core::fit::{Fit, FitSettings, ObjectiveKind};
use endcomfort_core::job::{ObjectiveFit, Output, SetShape, Stage, Update};
use endcomfort_core::superquadric::Superquadric;

use super::state::{StageState, Step};
use super::{Document, Effect, ViewerState};

/// What a person does in the fit lab.
#[derive(Clone, Debug, PartialEq)]
pub enum LabCommand {
    /// Opens a page of the inspector.
    Page(LabPage),
    /// Draws the fit another way.
    View(FitView),
    /// Draws the fit the next way round.
    NextView,
    /// Asks for a fit with other settings.
    Settings(FitSettings),
    /// Fits the shown cluster with every objective.
    Compare,
    /// Points at an objective.
    HoverObjective(Option<ObjectiveKind>),
    /// Points the view at the rejected points, or back at the whole cluster.
    PointOutRejected(bool),
    /// Sets a shape while a value is dragged.
    DragShape(SetShape),
    /// Sets a shape.
    SetShape(SetShape),
    /// The dragged value has been let go.
    EndDrag,
    /// Gives the cluster its fit back.
    BackToFit,
}

/// A page of the Fit step's inspector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LabPage {
    /// How well it fits, and which points count.
    #[default]
    Result,
    /// Every parameter, by hand.
    Shape,
    /// How it was found: objectives, models, runs.
    Search,
    /// What the fit is asked.
    Settings,
}

impl LabPage {
    /// All pages.
    pub const ALL: [Self; 4] = [Self::Result, Self::Shape, Self::Search, Self::Settings];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Result => "Result",
            Self::Shape => "Shape",
            Self::Search => "Search",
            Self::Settings => "Settings",
        }
    }
}

/// How a fit is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FitView {
    /// A body that the points shine through.
    #[default]
    Solid,
    /// Its parameter lines.
    Wire,
    /// Points coloured by their signed radial distance from it.
    Error,
}

impl FitView {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Solid, Self::Wire, Self::Error];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Solid => "Solid",
            Self::Wire => "Wire",
            Self::Error => "Error",
        }
    }
}

/// The state of the lab.
#[derive(Debug, Default)]
pub struct Lab {
    /// The page of the inspector.
    pub page: LabPage,
    /// How the fit is drawn.
    pub view: FitView,
    /// Whether the view points at the rejected points.
    pub points_out_rejected: bool,
    /// Why the last values are no shape; `None` if they are one.
    pub refused: Option<String>,
    /// The objectives side by side.
    pub comparison: Option<Comparison>,
    /// The objective whose row is under the pointer.
    pub hovered: Option<ObjectiveKind>,
    /// Whether the view shows the lab while the Fit step is selected: playing puts the robot in its place.
    pub(super) is_open: bool,
    drag: Drag,
}

/// What the lab adds to the picture; equal values give equal pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabKey {
    /// The cluster that is examined.
    pub cluster: usize,
    /// How its fit is drawn.
    pub view: FitView,
    /// Whether the view points at the rejected points.
    pub points_out_rejected: bool,
    /// The objective whose fit is drawn over it.
    pub objective: Option<ObjectiveKind>,
    /// Results of the comparison so far: another number, another picture.
    pub compared: usize,
}

/// A value on its way.
#[derive(Debug, Default)]
struct Drag {
    /// Whether the drag has its step of undo already.
    is_recorded: bool,
    /// Revision of the request for the Fit stage alone that has not been answered yet.
    asked: Option<u64>,
    /// The last stage that is to be asked for once it is.
    owed: Option<Stage>,
}

/// The five objectives on one cluster.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The cluster.
    pub cluster: usize,
    /// Results in the order in which they came, with their times in milliseconds.
    pub rows: Vec<(f64, ObjectiveFit)>,
    /// What was asked, but for what does not matter to it.
    basis: Document,
}

impl Comparison {
    /// What an objective made of the cluster, if it has been there already.
    pub fn fit(&self, objective: ObjectiveKind) -> Option<&Fit> {
        self.rows.iter().find(|(_, row)| row.objective == objective)?.1.fit.as_ref().ok()
    }
}

/// What a person calls an objective.
pub fn objective_title(objective: ObjectiveKind) -> &'static str {
    match objective {
        ObjectiveKind::Radial => "Radial",
        ObjectiveKind::Solina => "Solina",
        ObjectiveKind::Ichim => "Ichim",
        ObjectiveKind::Chevalier => "Chevalier",
        ObjectiveKind::F5 => "f5",
    }
}

/// A document without what a comparison of objectives does not depend on.
fn basis(document: &Document) -> Document {
    let mut basis = Document { cluster: None, grasp: None, shape: None, ..document.clone() };
    let scene = std::sync::Arc::make_mut(&mut basis.scene);
    scene.fit.objective = ObjectiveKind::Radial;
    basis
}

impl ViewerState {
    /// The cluster whose fit the inspector shows.
    pub fn examined_cluster(&self) -> Option<usize> {
        let output = self.outputs.fit.as_ref()?;
        Some(self.selection.cluster.filter(|&cluster| cluster < output.fits.len()).unwrap_or(output.target))
    }

    /// The fit that the inspector shows.
    pub fn examined_fit(&self) -> Option<&Fit> {
        self.outputs.fit.as_ref()?.fits.get(self.examined_cluster()?)?.as_ref().ok()
    }

    /// The fit that a shape set by hand stands in for, if the examined cluster has such a shape.
    pub fn automatic_fit(&self) -> Option<&Fit> {
        let shape = self.document.shape.filter(|shape| Some(shape.cluster) == self.examined_cluster());
        shape.and_then(|_| self.outputs.fit.as_ref()?.automatic.as_deref())
    }

    /// What the lab adds to the picture; `None` while the view shows the robot at work.
    pub fn lab_key(&self) -> Option<LabKey> {
        let cluster = self.examined_cluster()?;
        let shown = self.selection.step == Step::Stage(Stage::Fit) && self.lab.is_open && !self.playback.playing;
        let comparison = self.comparison();
        shown.then(|| LabKey {
            cluster,
            view: self.lab.view,
            points_out_rejected: self.lab.points_out_rejected,
            objective: self.lab.hovered.filter(|_| comparison.is_some()),
            compared: comparison.map_or(0, |comparison| comparison.rows.len()),
        })
    }

    /// The comparison of the objectives, if it belongs to the examined cluster and the present settings.
    pub fn comparison(&self) -> Option<&Comparison> {
        let comparison = self.lab.comparison.as_ref()?;
        let holds = Some(comparison.cluster) == self.examined_cluster() && comparison.basis == basis(&self.document);
        holds.then_some(comparison)
    }

    /// Whether objectives are being compared.
    pub fn is_comparing(&self) -> bool {
        self.running && self.comparison().is_some_and(|comparison| comparison.rows.len() < ObjectiveKind::ALL.len())
    }

    /// Whether a value is being dragged.
    pub fn is_dragging_shape(&self) -> bool {
        self.lab.drag.is_recorded
    }

    /// The examined cluster's shape with the fields of a JSON object in it.
    pub(super) fn shape_with(&self, parameters: &str) -> Result<SetShape, String> {
        let (Some(cluster), Some(fit)) = (self.examined_cluster(), self.examined_fit()) else {
            return Err("there is no fit whose shape could be set".to_owned());
        };
        let mut shape = serde_json::to_value(fit.superquadric).map_err(|error| error.to_string())?;
        let given: serde_json::Value = serde_json::from_str(parameters).map_err(|error| error.to_string())?;
        let (Some(fields), Some(given)) = (shape.as_object_mut(), given.as_object()) else {
            return Err("a shape is set by an object such as {\"a\": 0.05}".to_owned());
        };
        for (name, value) in given {
            if fields.insert(name.clone(), value.clone()).is_none() {
                return Err(format!("a superquadric has no parameter {name:?}"));
            }
        }
        let superquadric = serde_json::from_value(shape).map_err(|error| error.to_string())?;
        Ok(SetShape { cluster, superquadric })
    }

    pub(super) fn apply_lab(&mut self, command: LabCommand) -> Vec<Effect> {
        match command {
            LabCommand::Page(page) => self.lab.page = page,
            LabCommand::View(view) => {
                self.lab.view = view;
                self.lab.is_open = true;
                self.playback.playing = false;
            }
            LabCommand::NextView => {
                let next = (self.lab.view as usize + 1) % FitView::ALL.len();
                return self.apply_lab(LabCommand::View(FitView::ALL[next]));
            }
            LabCommand::Settings(settings) => {
                return self.edit(|document| {
                    std::sync::Arc::make_mut(&mut document.scene).fit = settings;
                    // Whoever asks for another fit wants to see it.
                    document.shape = None;
                    document.grasp = None;
                });
            }
            LabCommand::Compare => return self.compare(),
            LabCommand::HoverObjective(objective) => self.lab.hovered = objective,
            LabCommand::PointOutRejected(points_out) => {
                self.lab.points_out_rejected = points_out;
                self.lab.is_open = true;
                self.playback.playing = false;
            }
            LabCommand::DragShape(shape) => return self.set_shape(shape, true),
            LabCommand::SetShape(shape) => return self.set_shape(shape, false),
            LabCommand::EndDrag => return self.end_drag(),
            LabCommand::BackToFit => {
                self.lab.refused = None;
                return self.edit(|document| {
                    document.shape = None;
                    document.grasp = None;
                });
            }
        }
        Vec::new()
    }

    fn compare(&mut self) -> Vec<Effect> {
        let Some(cluster) = self.examined_cluster().filter(|_| !self.running) else { return Vec::new() };
        self.lab.comparison = Some(Comparison { cluster, rows: Vec::new(), basis: basis(&self.document) });
        self.running = true;
        let mut request = self.document.request(self.revision);
        request.compare = Some(cluster);
        vec![Effect::Run(Box::new(request))]
    }

    fn set_shape(&mut self, shape: SetShape, is_dragged: bool) -> Vec<Effect> {
        if self.outputs.fit.is_none() {
            return Vec::new();
        }
        let shape = match checked(&shape.superquadric) {
            Ok(superquadric) => SetShape { superquadric, ..shape },
            Err(reason) => {
                self.lab.refused = Some(reason);
                return Vec::new();
            }
        };
        self.lab.refused = None;
        if self.document.shape == Some(shape) {
            return Vec::new();
        }
        if !is_dragged {
            let effects = self.end_drag();
            let edited = self.edit(|document| {
                document.shape = Some(shape);
                document.grasp = None;
            });
            return if edited.is_empty() { effects } else { edited };
        }
        if !self.lab.drag.is_recorded {
            self.history.record(self.document.clone());
            self.lab.drag.is_recorded = true;
        }
        self.set_document(Document { shape: Some(shape), grasp: None, ..self.document.clone() });
        self.ask_from_fit(Stage::Fit)
    }

    fn end_drag(&mut self) -> Vec<Effect> {
        self.lab.refused = None;
        if !std::mem::take(&mut self.lab.drag.is_recorded) {
            return Vec::new();
        }
        if self.history.newest() == Some(&self.document) {
            // Let go where it was taken up: there is nothing to undo, but the later stages have been set aside.
            let _the_same = self.history.forget();
        }
        self.ask_from_fit(Stage::Plan)
    }

    /// Asks for the stages from Fit to `last`, or remembers to once the request that is under way has been answered.
    fn ask_from_fit(&mut self, last: Stage) -> Vec<Effect> {
        if self.lab.drag.asked.is_some() {
            self.lab.drag.owed = Some(last);
            return Vec::new();
        }
        self.running = true;
        self.lab.drag.asked = (last == Stage::Fit).then_some(self.revision);
        let mut request = self.document.request(self.revision);
        request.first = if self.has_current_clusters() { Stage::Fit } else { Stage::Scene };
        request.last = last;
        vec![Effect::Run(Box::new(request))]
    }

    /// Whether the cloud and its clusters are those of the present document.
    pub(super) fn has_current_clusters(&self) -> bool {
        [Stage::Scene, Stage::Segment].into_iter().all(|stage| self.outputs.revision(stage) == Some(self.revision))
    }

    /// Forgets a drag that something else has overtaken.
    pub(super) fn forget_drag(&mut self) {
        self.lab.drag = Drag::default();
    }

    /// Takes an update that belongs to the lab: `Err` gives back one that does not.
    pub(super) fn receive_in_lab(&mut self, update: Update) -> Result<Vec<Effect>, Update> {
        match update {
            Update::Done { revision, elapsed_ms, output } if matches!(*output, Output::Objective(_)) => {
                if let (Output::Objective(row), Some(comparison), true) =
                    (*output, &mut self.lab.comparison, revision == self.revision)
                {
                    comparison.rows.push((elapsed_ms, *row));
                }
                Ok(Vec::new())
            }
            Update::Done { revision, elapsed_ms, output } if self.lab.drag.asked == Some(revision) => {
                // The value may have moved on since: what it was a moment ago is shown until the next answer.
                // A drag changes the shape alone, so the cloud and its clusters are those of any later moment too.
                let is_lasting = matches!(*output, Output::Scene(_) | Output::Segment(_));
                let revision = if is_lasting { self.revision } else { revision };
                let stage = self.outputs.put(revision, *output);
                self.outputs_version += 1;
                if let Some(stage) = stage.filter(|_| revision == self.revision) {
                    *self.stage_mut(stage) = StageState::Done { elapsed_ms };
                }
                Ok(Vec::new())
            }
            Update::Finished { revision } if self.lab.drag.asked == Some(revision) => {
                self.lab.drag.asked = None;
                if let Some(last) = self.lab.drag.owed.take() {
                    return Ok(self.ask_from_fit(last));
                }
                if revision == self.revision {
                    self.running = false;
                }
                Ok(Vec::new())
            }
            update => Err(update),
        }
    }
}

/// The same shape, or why it is none.
fn checked(shape: &Superquadric) -> Result<Superquadric, String> {
    Superquadric::new(shape.a, shape.b, shape.c, shape.e1, shape.e2, shape.X_FS)
        .and_then(|made| made.deformed(shape.taper, shape.bend_per_m))
        .map_err(|error| error.to_string())
}

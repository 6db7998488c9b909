//! What the view shows, layer by layer.

use serde::{Deserialize, Serialize};

/// A thing that can be shown or hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    Robot,
    Cloud,
    Clusters,
    Fits,
    Goal,
    Handover,
    Grasps,
    Rejected,
    Contacts,
    Path,
    Routes,
    Ghosts,
    Swept,
    Reach,
}

impl Layer {
    /// All layers in the order of the list.
    pub const ALL: [Self; 14] = [
        Self::Robot,
        Self::Cloud,
        Self::Clusters,
        Self::Fits,
        Self::Goal,
        Self::Handover,
        Self::Grasps,
        Self::Rejected,
        Self::Contacts,
        Self::Path,
        Self::Routes,
        Self::Ghosts,
        Self::Swept,
        Self::Reach,
    ];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Robot => "Robot",
            Self::Cloud => "Cloud",
            Self::Clusters => "Clusters",
            Self::Fits => "Superquadric fits",
            Self::Goal => "Goal pose",
            Self::Grasps => "Grasps",
            Self::Rejected => "Rejected",
            Self::Contacts => "Contacts",
            Self::Path => "Path",
            Self::Routes => "Routes",
            Self::Ghosts => "Ghost poses",
            Self::Swept => "Swept volume",
            Self::Handover => "Handover",
            Self::Reach => "Reachability",
        }
    }
}

/// How one layer is shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerView {
    /// Whether it is shown.
    pub visible: bool,
    /// Opacity in [0, 1].
    pub opacity: f32,
}

/// How all layers are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers([LayerView; Layer::ALL.len()]);

impl Default for Layers {
    fn default() -> Self {
        let mut layers = Self([LayerView { visible: true, opacity: 1.0 }; Layer::ALL.len()]);
        for hidden in [Layer::Rejected, Layer::Ghosts, Layer::Swept, Layer::Reach] {
            layers.get_mut(hidden).visible = false;
        }
        layers
    }
}

impl Layers {
    /// How a layer is shown.
    pub fn get(&self, layer: Layer) -> LayerView {
        self.0[layer as usize]
    }

    pub fn get_mut(&mut self, layer: Layer) -> &mut LayerView {
        &mut self.0[layer as usize]
    }

    /// Opacity in [0, 1]; 0 when hidden.
    pub fn opacity(&self, layer: Layer) -> f32 {
        let view = self.get(layer);
        if view.visible { view.opacity } else { 0.0 }
    }
}

//! Stands in for `endcomfort::viewer::App` and `endcomfort_core::pipeline::Pipeline` until they are merged; has their shape.

use eframe::egui;
use endcomfort::host::Host;
use endcomfort_core::job::{Request, Update};
use endcomfort_core::scene::{ArmChoice, SCENE_VERSION, Scene, TableTop, Task};
use endcomfort_core::watch::Watch;
use nalgebra::Isometry3;

pub(crate) struct StartOptions {
    pub(crate) demo: Option<String>,
    pub(crate) gallery: bool,
    pub(crate) theme: ThemeChoice,
}

#[derive(Debug)]
pub(crate) enum ThemeChoice {
    System,
    Dark,
    Light,
}

pub(crate) struct App {
    host: Box<dyn Host>,
    revision: u64,
    finished: Option<u64>,
    query: String,
    note: String,
}

impl App {
    pub(crate) fn new(
        _creation: &eframe::CreationContext<'_>,
        mut host: Box<dyn Host>,
        start: StartOptions,
    ) -> Result<Self, String> {
        host.submit(request(1));
        Ok(Self {
            host,
            revision: 1,
            finished: None,
            query: format!("{:?} {} {:?}", start.demo, start.gallery, start.theme),
            note: String::new(),
        })
    }

    pub(crate) fn status_json(&mut self) -> String {
        serde_json::json!({
            "revision": self.revision,
            "running": self.finished != Some(self.revision),
            "backend": self.host.backend(),
            "note": self.note,
        })
        .to_string()
    }

    pub(crate) fn plan_json(&self) -> Option<String> {
        None
    }

    pub(crate) fn open_file(&mut self, _context: &egui::Context, name: String, bytes: Vec<u8>) {
        self.note = format!("{name}: {} bytes", bytes.len());
        self.revision += 1;
        self.host.submit(request(self.revision));
    }

    pub(crate) fn open_demo(&mut self, _context: &egui::Context, name: &str) {
        if name == "panic" {
            panic!("a panic that was asked for");
        }
        if name == "save" {
            self.note = self.host.save("note.txt", b"a note");
        }
        self.revision += 1;
        self.host.submit(request(self.revision));
    }

    pub(crate) fn set_playing(&mut self, _context: &egui::Context, _playing: bool) {}

    pub(crate) fn seek(&mut self, _context: &egui::Context, _time_s: f64) {}
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        for update in self.host.poll() {
            if let Update::Finished { revision } = update {
                self.finished = Some(revision);
            }
        }
        egui::CentralPanel::default().show(ui, |ui| {
            ui.heading("Endcomfort");
            ui.label(format!("{} · revision {} · {}", self.host.backend(), self.revision, self.query));
            ui.label(&self.note);
            ui.add(egui::Slider::new(&mut self.revision.clone(), 0..=10));
            for i in 0..12_u8 {
                let color = egui::Color32::from_rgb(20 * i, 255 - 20 * i, 128);
                let (rect, _) = ui.allocate_exact_size(egui::vec2(240.0, 24.0), egui::Sense::hover());
                ui.painter().rect_filled(rect, 6.0, color);
            }
        });
    }

    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}

pub(crate) struct Pipeline;

impl Pipeline {
    pub(crate) fn new() -> Self {
        Self
    }

    pub(crate) fn run(&mut self, request: &Request, _watch: &Watch<'_>, send: &mut dyn FnMut(Update)) {
        if request.scene.name == "panic" {
            panic!("a panic that was asked for");
        }
        send(Update::Finished { revision: request.revision });
    }
}

fn request(revision: u64) -> Request {
    let scene = Scene {
        version: SCENE_VERSION,
        name: "stand-in".into(),
        title: String::new(),
        summary: String::new(),
        robot: "alita".into(),
        arm: ArmChoice::Left,
        posture: "ready".into(),
        table: TableTop { center_m: [0.6, 0.0], size_m: [0.8, 1.2], height_m: 0.74, thickness_m: 0.04 },
        objects: Vec::new(),
        obstacles: Vec::new(),
        X_WC: Isometry3::identity(),
        task: Task::PickAndPlace { object: 0, X_WO_goal: Isometry3::translation(0.1, 0.0, 0.0) },
        seed: 1,
        segment: Default::default(),
        fit: Default::default(),
    };
    Request { revision, scene, cloud: None, cluster: None, grasp: None }
}

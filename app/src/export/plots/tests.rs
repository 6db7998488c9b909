//! Plots of a planned demo, read back as XML.

use roxmltree::{Document, Node};

use super::*;
use crate::assets;
use crate::jobs::run_until;
use endcomfort_core::job::{Output, Request};

fn elements<'a>(document: &'a Document<'_>, name: &str) -> Vec<Node<'a, 'a>>
where
{
    document.descendants().filter(|node| node.has_tag_name(name)).collect()
}

/// Every plot of a planned demo.
fn plots() -> Vec<(PlotKind, String)> {
    let request = Request::new(assets::demo("mustard").expect("a demo"));
    let robot = assets::library().robot_of(&request.scene).expect("its robot");
    let found = run_until(&request, Stage::Plan).expect("it can be planned");
    let fit = found.iter().find_map(|output| if let Output::Fit(fit) = output { Some(fit) } else { None });
    let plan = found.iter().find_map(|output| if let Output::Plan(plan) = output { Some(&**plan) } else { None });
    let results = Results { robot: &robot, segment: None, fit, objectives: &[], plan, tries: &[], maps: [None, None] };
    let plot = |kind| (kind, plot_svg(&results, &request.scene, kind, None).expect("a plot"));
    PlotKind::ALL.into_iter().map(plot).collect()
}

#[test]
fn every_plot_is_xml_with_as_many_curves_as_series_inside_its_frame() {
    for (kind, text) in plots() {
        let document = Document::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", kind.name()));
        let lines = elements(&document, "polyline");
        match kind {
            PlotKind::Timeline => assert_eq!(lines.len(), 2),
            PlotKind::Joints(_) => assert_eq!(lines.len(), 7, "one for each joint of the arm"),
            PlotKind::Cost => assert!(lines.len() > 1, "several runs"),
            PlotKind::Residuals => assert!(lines.is_empty() && elements(&document, "rect").len() > 20, "bars"),
        }
        for line in lines {
            let points = line.attribute("points").expect("points");
            let places: Vec<(f64, f64)> = points
                .split_whitespace()
                .map(|pair| pair.split_once(',').expect("x,y"))
                .map(|(x, y)| (x.parse().expect("a number"), y.parse().expect("a number")))
                .collect();
            assert!(places.len() > 1, "{}", kind.name());
            assert!(places.iter().all(|(x, _)| (65.9..=702.1).contains(x)), "{}: {points}", kind.name());
        }
        let words: Vec<&str> = elements(&document, "text").iter().filter_map(Node::text).collect();
        let unit = match kind {
            PlotKind::Cost => "rms of the residuals, mm",
            PlotKind::Residuals => "distance from the surface, mm (negative inside)",
            PlotKind::Timeline | PlotKind::Joints(_) => "time, s",
        };
        assert!(words.contains(&unit), "{}: {words:?}", kind.name());
        if let Some(folder) = std::env::var_os("ENDCOMFORT_LOOK") {
            let file = std::path::Path::new(&folder).join(format!("plot-{}.svg", kind.name()));
            std::fs::write(file, &text).expect("the folder can be written");
        }
    }
}

#[test]
fn what_is_not_there_yet_is_told() {
    let scene = assets::demo("mustard").expect("a demo");
    let robot = assets::library().robot_of(&scene).expect("its robot");
    let none = Results {
        robot: &robot,
        segment: None,
        fit: None,
        objectives: &[],
        plan: None,
        tries: &[],
        maps: [None, None],
    };
    for kind in PlotKind::ALL {
        let refused = plot_svg(&none, &scene, kind, None).expect_err("nothing is there");
        assert!(refused == "there is no plan" || refused == "there is no fit", "{refused}");
    }
}

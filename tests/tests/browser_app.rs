//! The whole program in a real browser: a demo plans and plays, dropped files are fitted or refused in words, and the
//! plan is the one that the same seed gives natively.

use std::fmt::Write as _;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow};
use endcomfort::assets;
use endcomfort::jobs::run_until;
use endcomfort_core::job::{Output, Request, Stage};
use endcomfort_core::task::plan_json_lines;
use endcomfort_tests::browser::{Browser, CONTROL, ENTER, ESCAPE};
use serde_json::Value;

const A_WHILE: Duration = Duration::from_secs(120);

/// The entry of a stage in the status.
fn stage<'a>(status: &'a Value, name: &str) -> &'a Value {
    let stages = status["stages"].as_array();
    stages.and_then(|stages| stages.iter().find(|stage| stage["stage"] == name)).unwrap_or(&Value::Null)
}

fn has_settled(status: &Value) -> bool {
    status["running"] == false
}

fn browser_with_demo(name: &str) -> Result<Browser> {
    let browser = Browser::with_webgl()?;
    browser.open("?renderer=webgl")?;
    browser.wait_until_it_runs()?;
    browser.run("window.endcomfort.set_demo(arguments[0])", &[name.into()])?;
    browser.wait_for_status(&format!("the demo {name}"), A_WHILE, |status| {
        status["demo"] == name && has_settled(status) && stage(status, "plan")["state"] != "waiting"
    })?;
    Ok(browser)
}

fn plan_in_browser(browser: &Browser) -> Result<String> {
    let plan = browser.run("return window.endcomfort.plan_json()", &[])?;
    Ok(plan.as_str().context("there is no plan")?.to_owned())
}

/// A table of 80 cm × 80 cm with a can (radius 4 cm, height 14 cm) in its middle, seen from the front: ascii PCD in the
/// sensor's frame (x right, y down, z forward).
fn can_on_a_table() -> String {
    let mut points = Vec::new();
    let (sin, cos) = 40_f64.to_radians().sin_cos();
    // World: x away from the camera, y left, z up, origin at the can's foot. The camera looks down by 40°.
    let mut add = |x: f64, y: f64, z: f64| {
        let (ahead, above) = (x + 0.8, z - 0.67);
        points.push([-y, -(ahead * sin + above * cos), ahead * cos - above * sin]);
    };
    for i in 0..160 {
        for j in 0..160 {
            let (x, y) = (f64::from(i) * 0.005 - 0.4, f64::from(j) * 0.005 - 0.4);
            // The can hides the table beneath it and behind it.
            if y.abs() > 0.04 || !(-0.04..0.2).contains(&x) {
                add(x, y, 0.0);
            }
        }
    }
    for i in 0..60 {
        let angle = std::f64::consts::PI * (0.5 + f64::from(i) / 59.0);
        for j in 0..47 {
            add(0.04 * angle.cos(), 0.04 * angle.sin(), f64::from(j) * 0.003);
        }
    }
    for i in -13..=13 {
        for j in -13..=13 {
            let (x, y) = (f64::from(i) * 0.003, f64::from(j) * 0.003);
            if x.hypot(y) <= 0.04 {
                add(x, y, 0.14);
            }
        }
    }
    let count = points.len();
    let mut text = format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA ascii\n"
    );
    for [x, y, z] in points {
        let _ = writeln!(text, "{x:.5} {y:.5} {z:.5}");
    }
    text
}

#[test]
fn a_demo_plans_and_plays() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    let status = browser.status()?;
    assert_eq!(stage(&status, "plan")["state"], "done", "{status:#}");
    let duration_s = status["duration_s"].as_f64().context("a plan has a duration")?;

    browser.run("window.endcomfort.pause(); window.endcomfort.seek(0)", &[])?;
    browser.wait_until_it_rests()?;
    let start = browser.screenshot("mustard-start")?;
    browser.run("window.endcomfort.seek(arguments[0])", &[(0.6 * duration_s).into()])?;
    browser.wait_for_status("the sought time", A_WHILE, |status| {
        status["time_s"].as_f64().is_some_and(|time_s| (time_s - 0.6 * duration_s).abs() < 1e-6)
    })?;
    browser.wait_until_it_rests()?;
    let later = browser.screenshot("mustard-later")?;
    // Above the timeline nothing moves but the robot and what it carries; seen from the demo's camera, an arm covers
    // about one pixel in a hundred.
    let moved = start.top(0.75).difference(&later.top(0.75));
    assert!(moved > 0.003, "only {moved:.4} of the view differs");

    browser.run("window.endcomfort.seek(0); window.endcomfort.play()", &[])?;
    browser.wait_for_status("a plan that plays", A_WHILE, |status| {
        status["playing"] == true && status["time_s"].as_f64().is_some_and(|time_s| time_s > 0.2)
    })?;
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

#[test]
fn a_page_that_nobody_touches_draws_nothing() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    browser.run("window.endcomfort.pause()", &[])?;
    // A software renderer draws a draft, and the picture in full a second or more later; after that there is nothing to do.
    let mut before = Value::Null;
    for _ in 0..12 {
        let frames = browser.status()?["frames"].clone();
        if frames == before {
            break;
        }
        before = frames;
        std::thread::sleep(Duration::from_secs(4));
    }
    assert_eq!(browser.status()?["frames"], before, "frames are drawn although nothing happens");
    browser.run("window.endcomfort.seek(1)", &[])?;
    browser.wait_for_status("a frame for what was asked", A_WHILE, |status| status["frames"] != before)?;
    Ok(())
}

#[test]
fn in_the_fit_lab_objectives_are_compared_and_a_shape_set_by_hand_changes_the_error_until_it_is_undone() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    browser.run("window.endcomfort.pause(); window.endcomfort.select_step('fit')", &[])?;
    let status =
        browser.wait_for_status("the lab", A_WHILE, |status| status["step"] == "fit" && status["fit"].is_object())?;
    let fitted_m = status["fit"]["radial_m"].as_f64().context("a fit has an error")?;
    let a_m = status["fit"]["superquadric"]["a"].as_f64().context("a fit has semi-axes")?;
    browser.wait_until_it_rests()?;
    browser.screenshot("lab")?;

    browser.run("window.endcomfort.compare_objectives()", &[])?;
    let status = browser.wait_for_status("five objectives", A_WHILE, |status| {
        has_settled(status) && status["objectives"].as_array().is_some_and(|rows| rows.len() == 5)
    })?;
    assert_eq!(status["objectives"][0]["objective"], "radial", "{status:#}");
    assert_eq!(status["objectives"][0]["radial_m"].as_f64(), Some(fitted_m), "the first is the one that stands");

    browser.run("window.endcomfort.set_shape({ a: arguments[0] })", &[(1.3 * a_m).into()])?;
    let by_hand = |status: &Value| status["fit"]["by_hand"] == true && stage(status, "fit")["state"] == "done";
    let status = browser.wait_for_status("the shape set by hand", A_WHILE, by_hand)?;
    assert!(status["fit"]["radial_m"].as_f64().is_some_and(|radial_m| radial_m > 1.5 * fitted_m), "{status:#}");
    let status = browser.wait_for_status("grasps of that shape", A_WHILE, has_settled)?;
    assert_eq!(status["step"], "fit", "whatever becomes of the plan, the lab stays: {status:#}");
    browser.screenshot("lab-by-hand")?;
    let refused = browser.run("window.endcomfort.set_shape({ e1: 7 })", &[]);
    assert!(refused.is_err_and(|error| format!("{error:#}").contains("exponent e1 is 7")));

    browser.run("window.endcomfort.undo()", &[])?;
    let status = browser.wait_for_status("the fit as it was", A_WHILE, |status| {
        status["fit"]["by_hand"] == false && has_settled(status)
    })?;
    assert_eq!(status["fit"]["radial_m"].as_f64(), Some(fitted_m), "{status:#}");
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

/// The last file that the page handed to the person after `window.saved` began to collect them.
fn saved_file(browser: &Browser, count: usize) -> Result<Vec<u8>> {
    browser.wait_for(&format!("file {count}"), &format!("window.saved?.length >= {count}"), A_WHILE)?;
    let text = browser.run(
        "const hex = (byte) => byte.toString(16).padStart(2, '0');
         return window.saved.at(-1).arrayBuffer().then((file) => Array.from(new Uint8Array(file), hex).join(''))",
        &[],
    )?;
    let text = text.as_str().context("no bytes")?;
    (0..text.len()).step_by(2).map(|at| Ok(u8::from_str_radix(&text[at..at + 2], 16)?)).collect()
}

#[test]
fn pictures_and_animations_of_any_size_are_saved_while_the_page_goes_on() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    browser.run(
        "window.saved = []; const make = URL.createObjectURL.bind(URL);
         URL.createObjectURL = (blob) => { window.saved.push(blob); return make(blob); };
         window.endcomfort.pause(); window.endcomfort.seek(4)",
        &[],
    )?;
    let size = serde_json::json!({ "width": 500, "height": 300, "transparent": true, "words": false });
    browser.run("window.endcomfort.save_picture(arguments[0])", &[size])?;
    let picture = image::load_from_memory(&saved_file(&browser, 1)?)?.to_rgba8();
    assert_eq!(picture.dimensions(), (500, 300));
    assert_eq!(picture.get_pixel(0, 0).0[3], 0, "no background");
    let seen = picture.pixels().filter(|pixel| pixel.0[3] == 255).count();
    assert!(seen > 500 * 300 / 20, "only {seen} pixels of robot and table");

    let clip = serde_json::json!({
        "width": 200, "height": 120, "format": "apng", "fps": 2, "from_s": 4, "to_s": 5.5, "words": true
    });
    browser.run("window.endcomfort.save_animation(arguments[0])", &[clip])?;
    let file = saved_file(&browser, 2)?;
    assert_eq!(file.windows(4).filter(|window| *window == b"fcTL").count(), 4, "one for each frame");
    assert_eq!(image::load_from_memory(&file)?.to_rgba8().dimensions(), (200, 120));

    let refused = browser.run(
        "try { window.endcomfort.save_picture({ width: 90000 }); return '' } catch (error) { return String(error) }",
        &[],
    )?;
    assert!(refused.as_str().is_some_and(|said| said.contains("90000 × 720")), "{refused}");
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

#[test]
fn a_dropped_cloud_is_fitted() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    browser.drop_file("can.pcd", can_on_a_table().as_bytes())?;
    let status = browser
        .wait_for_status("the dropped file", A_WHILE, |status| status["file"] == "can.pcd" && has_settled(status))?;
    browser.screenshot("dropped")?;
    assert_eq!(stage(&status, "fit")["state"], "done", "{status:#}");
    assert_eq!(status["clusters"], 1, "{status:#}");
    // The cloud is exact, so what is left is the superquadric's own shape against a cylinder's edge.
    assert!(status["fit_radial_m"].as_f64().is_some_and(|radial_m| radial_m < 0.005), "{status:#}");
    Ok(())
}

#[test]
fn a_truncated_cloud_is_refused_in_words_and_the_scene_stays() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    let before = plan_in_browser(&browser)?;
    let whole = can_on_a_table();
    let cut = &whole.as_bytes()[..whole.len() / 3];
    browser.drop_file("cut.pcd", cut)?;
    let said = |status: &Value| {
        let messages = status["messages"].to_string();
        let reasons: String =
            status["stages"].as_array().into_iter().flatten().map(|s| s["reason"].to_string()).collect();
        messages.contains("cut.pcd") || reasons.contains("cut.pcd")
    };
    let status =
        browser.wait_for_status("a message about the file", A_WHILE, |status| said(status) && has_settled(status))?;
    browser.screenshot("truncated")?;
    assert_eq!(status["demo"], "mustard", "the scene stays: {status:#}");
    assert_eq!(plan_in_browser(&browser)?, before, "and so does its plan");
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

#[test]
fn the_plan_for_a_seed_is_the_same_text_in_the_browser_and_natively() -> Result<()> {
    for demo in assets::DEMOS {
        let scene = assets::demo(demo).context("no such demo")?;
        let robot = assets::library().robot_of(&scene)?;
        let request = Request::new(scene);
        let outputs = run_until(&request, Stage::Plan).map_err(|refusal| anyhow!("{refusal:?}"))?;
        let plan =
            outputs.into_iter().find_map(|output| if let Output::Plan(plan) = output { Some(plan) } else { None });
        let plan = plan.context("no plan")?;
        let lines = plan_json_lines(&plan, &robot);
        let native = lines.iter().map(Value::to_string).collect::<Vec<_>>().join("\n");
        let browser = plan_in_browser(&browser_with_demo(demo)?)?;
        let differs = native.bytes().zip(browser.bytes()).position(|(a, b)| a != b);
        assert!(native == browser, "{demo}: the plans differ from byte {differs:?} on");
    }
    Ok(())
}

/// What a link has to bring back.
fn shared_part(status: &Value) -> Vec<&Value> {
    let keys = ["scene", "demo", "seed", "step", "selected_grasp", "planned_grasp", "duration_s", "time_s", "camera"];
    keys.iter().map(|key| &status[key]).collect()
}

#[test]
fn a_link_opens_the_same_view_with_the_same_plan_and_the_edit_is_kept_for_the_next_visit() -> Result<()> {
    let browser = browser_with_demo("jar")?;
    let mut scene = assets::demo("jar").context("no such demo")?;
    scene.seed = 5;
    browser.drop_file("mine.json", serde_json::to_string(&scene)?.as_bytes())?;
    browser.wait_for_status("the edited demo", A_WHILE, |status| {
        status["seed"] == 5 && has_settled(status) && stage(status, "plan")["state"] == "done"
    })?;
    browser
        .run("window.endcomfort.pause(); window.endcomfort.select_step('rank'); window.endcomfort.seek(3.25)", &[])?;
    browser.wait_until_it_rests()?;
    let link = browser.run("return window.endcomfort.link()", &[])?;
    let link = link.as_str().context("a link is text")?;
    println!("{} characters: {link}", link.len());
    let plan = plan_in_browser(&browser)?;
    let kept = browser.wait_for("the kept edit", "localStorage.getItem('endcomfort_session')", A_WHILE)?;
    assert!(kept.as_str().is_some_and(|text| text.contains("\"seed\":5")), "{kept}");

    // A page that is not there in between: else the browser would take the link as a place on the same page.
    browser.open("nothing")?;
    let (_, packed) = link.split_once('#').context("a link has a part after #")?;
    browser.open(&format!("?renderer=webgl#{packed}"))?;
    browser.wait_until_it_runs()?;
    let opened = browser.wait_for_status("the link's plan", A_WHILE, |status| {
        has_settled(status) && stage(status, "plan")["state"] == "done" && status["time_s"] == 3.25
    })?;
    browser.screenshot("shared")?;
    assert_eq!(plan_in_browser(&browser)?, plan, "the same plan, to the last digit");
    assert_eq!(browser.run("return window.endcomfort.link()", &[])?, link, "and it is shared as the same link");
    assert_eq!(opened["demo"], "jar");

    browser.run("location.hash = '#s=broken!'", &[])?;
    let told = browser.wait_for_status("a word about the broken link", A_WHILE, |status| {
        status["messages"].to_string().contains("The link could not be opened")
    })?;
    assert_eq!(shared_part(&told), shared_part(&opened), "everything else stays");
    let complaints = browser.complaints()?;
    // The page that is not there, with its icon.
    let complaints: Vec<_> = complaints.iter().filter(|line| !line.contains("404")).collect();
    assert!(complaints.is_empty(), "{complaints:#?}");

    browser.open("?renderer=webgl")?;
    browser.wait_until_it_runs()?;
    browser.wait_until_it_rests()?;
    browser.screenshot("restore")?;
    Ok(())
}

#[test]
fn the_example_drives_the_page_in_its_frame() -> Result<()> {
    let browser = Browser::with_webgl()?;
    browser.open("example/embed.html")?;
    let said = |words: &str| format!("document.getElementById('log').innerText.includes('{words}')");
    browser.wait_for("the frame", &said("ready"), A_WHILE)?;
    browser.run("document.getElementById('jar').click()", &[])?;
    browser.wait_for("the jar", &said("The jar is opened."), A_WHILE)?;
    let in_frame = "JSON.parse(document.getElementById('frame').contentWindow.endcomfort.status())";
    let planned = format!("(({in_frame}).demo === 'jar' && ({in_frame}).duration_s > 0)");
    browser.wait_for("the jar's plan", &planned, A_WHILE)?;
    browser.wait_for("the event", &said("stage plan done"), A_WHILE)?;
    browser.run("document.getElementById('half').click()", &[])?;
    browser.wait_for("the middle", &said("Now at"), A_WHILE)?;
    browser.run("document.getElementById('link').click()", &[])?;
    browser.wait_for("the link", &said("Link: http"), A_WHILE)?;
    assert_eq!(browser.run(&format!("return ({in_frame}).playing"), &[])?, false);

    let turn_wheel = "
        const view = document.getElementById('frame').contentDocument.getElementById('view');
        const wheel = new WheelEvent('wheel', { deltaY: 100, bubbles: true, cancelable: true });
        view.dispatchEvent(wheel);
        return wheel.defaultPrevented";
    assert_eq!(browser.run(turn_wheel, &[])?, false, "the wheel is left to the page around");
    let click = "
        const view = document.getElementById('frame').contentDocument.getElementById('view');
        view.dispatchEvent(new PointerEvent('pointerdown', { bubbles: true, clientX: 400, clientY: 200 }))";
    browser.run(click, &[])?;
    assert_eq!(browser.run(turn_wheel, &[])?, true, "after a click it zooms");
    std::thread::sleep(Duration::from_secs(1));
    browser.screenshot("embed")?;
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

#[test]
fn a_worker_that_cannot_start_is_told_in_the_steps() -> Result<()> {
    let browser = Browser::with_webgl()?;
    browser.before_the_page(
        "const Original = Worker; window.Worker = function (url, options) { return new Original('gone.js', options); };",
    )?;
    browser.open("?renderer=webgl")?;
    browser.wait_until_it_runs()?;
    let status =
        browser.wait_for_status("a refusal", A_WHILE, |status| stage(status, "scene")["state"] == "refused")?;
    assert!(stage(&status, "scene")["reason"].to_string().contains("fault in the program"), "{status:#}");
    Ok(())
}

#[test]
fn a_demo_is_found_opened_and_stepped_through_from_the_keyboard_alone() -> Result<()> {
    let browser = Browser::with_webgl()?;
    browser.open("?renderer=webgl")?;
    browser.wait_until_it_runs()?;
    // The software renderer draws a picture a second or fewer: whoever types before one types into what is not there.
    let shows = |overlay: Option<&'static str>| {
        browser.wait_for_status("the window of a key", A_WHILE, move |status| status["overlay"].as_str() == overlay)
    };
    shows(Some("gallery"))?;
    browser.press(&[ESCAPE])?;
    shows(None)?;
    browser.chord(CONTROL, "k")?;
    shows(Some("palette"))?;
    let letters: Vec<String> = "turns a glass".chars().map(String::from).collect();
    browser.press(&letters.iter().map(String::as_str).collect::<Vec<_>>())?;
    browser.screenshot("keyboard-palette")?;
    browser.press(&[ENTER])?;
    browser.wait_for_status("the demo chosen by its name", A_WHILE, |status| {
        status["demo"] == "glass" && has_settled(status) && stage(status, "plan")["state"] == "done"
    })?;
    let is_playing = |status: &Value| status["playing"] == true;
    if is_playing(&browser.status()?) {
        browser.press(&[" "])?;
        browser.wait_for_status("a plan that rests", A_WHILE, |status| !is_playing(status))?;
    }
    browser.press(&["."])?;
    browser.wait_for_status("the next sample", A_WHILE, |status| status["time_s"].as_f64().is_some_and(|t| t > 0.0))?;
    // Another projection, another side: the camera obeys keys as well.
    let yaw = |status: &Value| status["camera"]["yaw_rad"].as_f64();
    let before = yaw(&browser.status()?);
    browser.press(&["3"])?;
    browser.wait_for_status("another side", A_WHILE, |status| yaw(status) != before)?;
    browser.screenshot("keyboard-alone")?;
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

#[test]
fn one_finger_turns_the_view_and_two_bring_it_nearer() -> Result<()> {
    let browser = browser_with_demo("mustard")?;
    browser.run("window.endcomfort.pause()", &[])?;
    browser.wait_until_it_rests()?;
    let camera = |browser: &Browser| -> Result<[f64; 2]> {
        let camera = browser.status()?["camera"].clone();
        let number = |name: &str| camera[name].as_f64().context("a camera has numbers");
        Ok([number("yaw_rad")?, number("distance_m")?])
    };
    // Beside the robot, where nothing can be taken hold of.
    let [yaw, distance] = camera(&browser)?;
    browser.touch(&[([330, 200], [450, 200])])?;
    browser.wait_until_it_rests()?;
    let [turned, same] = camera(&browser)?;
    assert!((turned - yaw).abs() > 0.2, "from {yaw} to {turned} rad");
    assert!((same - distance).abs() < 1e-6, "from {distance} to {same} m");
    browser.touch(&[([420, 300], [340, 300]), ([520, 300], [600, 300])])?;
    browser.wait_until_it_rests()?;
    let [_, nearer] = camera(&browser)?;
    assert!(nearer < 0.8 * distance, "from {distance} to {nearer} m");
    browser.screenshot("two-fingers")?;
    let complaints = browser.complaints()?;
    assert!(complaints.is_empty(), "{complaints:#?}");
    Ok(())
}

use crate::page::report::made_up::{MadeUp, report, scenes, whole};
use crate::page::report::*;

fn page_of(scenes: &[MadeUp], within: f64) -> String {
    let scenes: Vec<Scene<'_>> = scenes.iter().map(MadeUp::scene).collect();
    page(&Input {
        report: &report(),
        scenes: &scenes,
        within,
        minutes: 1.0,
        does_not_show: &["speed & more"],
        static_costs: &[],
    })
}

#[test]
fn every_section_is_there_and_nothing_comes_from_elsewhere() {
    let page = whole();
    let titles = [
        "Which configuration to take",
        "court",
        "chalk",
        "&lt;night&gt; &amp; &quot;shade&quot;",
        "Numbers held to promises",
        "What this does not show",
        "How to make it again",
    ];
    let places = titles.map(|title| page.find(&format!("<h2>{title}</h2>")));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
    for word in ["http:", "https:", "@import", "url(", "<link", "src=\"/", "src=\"."] {
        assert!(!page.contains(word), "{word}");
    }
    let sources: Vec<&str> = page.split("src=\"").skip(1).map(|rest| &rest[..22]).collect();
    assert!(sources.iter().all(|source| *source == "data:image/png;base64,"), "{sources:?}");
    assert!(sources.len() > 12, "{}", sources.len());
}

#[test]
fn what_others_wrote_is_text_and_no_coordinate_is_odd() {
    let page = whole();
    for word in ["<night>", "<made up>", "power <", "<light>"] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(
        page.contains("clusters-&lt;&amp;&quot;image&quot;-0")
            && page.contains("an adapter &lt;made up&gt;")
    );
    for drawing in page.split("<svg").skip(1).filter_map(|rest| rest.split("</svg>").next()) {
        let tags: Vec<&str> =
            drawing.split('<').filter_map(|part| part.split('>').next()).collect();
        for tag in tags {
            let coordinates = ["x=", "y=", "points=", "width=", "height="];
            let odd = tag.contains("NaN") || tag.contains("inf");
            assert!(!(odd && coordinates.iter().any(|name| tag.contains(name))), "{tag}");
        }
    }
}

#[test]
fn every_configuration_of_the_frontier_has_its_picture_and_each_dominated_one_what_dominates_it() {
    let scenes = scenes();
    for scene in &scenes {
        let page = page_of(std::slice::from_ref(scene), 0.05);
        let frontier = scene
            .measured
            .configurations
            .iter()
            .filter(|configuration| !configuration.frontiers.is_empty())
            .count();
        assert!(frontier > 0, "{}: there is something to choose", scene.measured.scene);
        let strips = page.matches("<figure class=\"compare\">").count();
        let shown = scene
            .measured
            .configurations
            .iter()
            .filter(|configuration| configuration.is_shown())
            .count();
        assert_eq!(strips, shown, "{}", scene.measured.scene);
        assert_eq!(page.matches("no picture").count(), 0);
        let dominated: usize = scene
            .measured
            .configurations
            .iter()
            .map(|configuration| configuration.dominated.len())
            .sum();
        let rows = page.matches("<tr data-key=").count();
        assert_eq!(rows, dominated);
        for configuration in &scene.measured.configurations {
            let name = html! { (configuration.name) }.into_string();
            assert_eq!(
                !configuration.dominated.is_empty(),
                page.contains(&format!("<td class=\"code\">{name}")),
                "{name}"
            );
        }
    }
}

#[test]
fn lists_of_a_cut_have_pictures_and_numbers() {
    let scenes = scenes();
    let shown = page_of(&scenes[..1], 0.05);
    assert!(
        shown.contains("length of each tile&#39;s list, at most 380")
            || shown.contains("length of each tile's list, at most 380")
    );
    assert!(shown.contains("0 of 240 stopped refining"), "numbers");
    let without = page_of(&scenes[1..2], 0.05);
    assert!(
        without.contains("The default has no cut for each tile.")
            && !without.contains("stopped refining")
    );
}

#[test]
fn a_missing_picture_is_told() {
    let mut scenes = scenes();
    scenes.truncate(1);
    let names: Vec<String> = scenes[0].pictures.configurations.keys().cloned().collect();
    scenes[0].pictures.configurations.remove(&names[0]);
    if let Some(short) = scenes[0].pictures.configurations.get_mut(&names[1]) {
        short.pop();
    }
    let page = page_of(&scenes, 0.05);
    assert!(
        page.contains("no picture was kept")
            && page.contains("no picture: error: a picture of 160 x 90")
    );
    scenes[0].pictures.reference.clear();
    assert!(page_of(&scenes, 0.05).contains("There is no picture of the reference"));
}

#[test]
fn the_answer_is_the_cheapest_that_is_good_enough() {
    let mut scenes = scenes();
    scenes.truncate(1);
    let name = |scenes: &[MadeUp], within: f64| {
        let scene = scenes[0].scene();
        let named = Named::new(0, &scene, Metric::default());
        let advice = advice::advise(&named, within).unwrap();
        (advice.good.clone(), advice.best.clone(), advice.by_floor)
    };
    let (exact, best, _) = name(&scenes, 0.0);
    assert_eq!(exact.name, best.name);
    let (wide, _, by_floor) = name(&scenes, 1.0);
    assert!(!by_floor && wide.time.median < exact.time.median);
    assert!(wide.picture.relative_mse <= 2.0 * best.picture.relative_mse);
    let cheaper = |configuration: &&sglow_results::frontier::document::Configuration| {
        configuration.complete
            && configuration.picture.relative_mse <= 2.0 * best.picture.relative_mse
    };
    let least = scenes[0]
        .measured
        .configurations
        .iter()
        .filter(cheaper)
        .map(|configuration| configuration.time.median)
        .fold(f64::INFINITY, f64::min);
    assert_eq!(wide.time.median, least);
    // Errors below the uncertainty of the minimum count as the same.
    let least = scenes[0]
        .measured
        .configurations
        .iter_mut()
        .min_by(|one, other| one.picture.relative_mse.total_cmp(&other.picture.relative_mse));
    least.unwrap().picture.uncertainty.relative_mse = 10.0;
    let (under, _, by_floor) = name(&scenes, 0.0);
    assert!(by_floor && under.time.median < wide.time.median);
    // What leaves light out is no choice, however cheap.
    for configuration in &mut scenes[0].measured.configurations {
        configuration.complete = false;
    }
    assert!(page_of(&scenes, 0.05).contains("there is nothing to recommend"));
}

#[test]
fn words_name_axes_and_parameters_that_differ() {
    let mut scenes = scenes();
    let default = scenes[0]
        .measured
        .configurations
        .iter()
        .find(|configuration| configuration.default)
        .unwrap()
        .clone();
    let mut other = default.clone();
    other.default = false;
    other.name = "emitter=lobe,lights=64".to_owned();
    other.axes.insert("emitter".to_owned(), "lobe".to_owned());
    other.parameters.insert("lights".to_owned(), "64".to_owned());
    scenes[0].measured.configurations = vec![default, other];
    let scene = scenes[0].scene();
    let named = Named::new(0, &scene, Metric::default());
    assert_eq!(named.words(&scene.measured.configurations[1]), "emitter lobe, lights 64");
    assert_eq!(named.words(&scene.measured.configurations[0]), "default");
}

#[test]
fn numbers_stand_where_they_are_looked_for() {
    let scenes = scenes();
    let page = page_of(&scenes, 0.05);
    let answers = &page[page.find("id=\"answer\"").unwrap()..page.find("id=\"scene-0\"").unwrap()];
    for scene in &scenes {
        let scene = scene.scene();
        let named = Named::new(0, &scene, Metric::default());
        let advice = advice::advise(&named, 0.05).unwrap();
        assert!(
            answers.contains(&format!("<strong>{} ms</strong>", figure(advice.good.time.median)))
        );
        assert!(answers.contains(&named.cell(advice.good)));
    }
    for part in [
        "no claim below",
        "0x42b20000",
        "43.9\u{a0}%",
        "Both pictures are the same, bit for bit.",
        "no-specular-surface",
        "all 13 materials have no specular reflectance",
        "error not finite",
        "errors are absolute",
        "more than <strong>6 bisection steps</strong> does not pay",
        "speed &amp; more",
        "1 promise is broken, 1 kept",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn pictures_that_differ_are_not_called_the_same() {
    let mut scenes = scenes();
    if let Some(pruned) = &mut scenes[1].measured.pruned {
        pruned.differing = 1234;
    }
    let page = page_of(&scenes, 0.05);
    assert!(page.contains("1,234 numbers of the pictures differ") && !page.contains("bit for bit"));
}

#[test]
fn nothing_measured_is_no_success() {
    let nothing = page(&Input {
        report: &Report::new(),
        scenes: &[],
        within: 0.05,
        minutes: 0.0,
        does_not_show: &[],
        static_costs: &[],
    });
    assert!(nothing.contains("Nothing was checked") && nothing.contains("No scene was measured"));
    let mut scenes = scenes();
    scenes.truncate(1);
    scenes[0].measured.configurations.clear();
    let empty = page_of(&scenes, 0.05);
    assert!(empty.contains("nothing to plot") && empty.contains("nothing to recommend"));
}

#[test]
fn the_reader_picks_the_metric_and_sees_where_metrics_disagree() {
    let page = whole();
    // Without a script only the default metric is shown.
    for metric in Metric::ALL {
        let hidden = format!("<div data-metric=\"{}\" hidden>", metric.name());
        assert_eq!(page.contains(&hidden), metric != Metric::default(), "{metric}");
        assert!(page.contains(&format!("<option value=\"{}\">", metric.name())));
        assert!(page.contains(&format!("error: {}", metric.title())));
    }
    assert_eq!(page.matches("Where metrics disagree</h3>").count(), scenes().len());
    assert!(page.contains("on the frontier by some metrics and dominated by others"));
    assert!(page.contains("Against the reference without visibility"));
    // Where there is one metric's frontier for all, the page says that.
    let mut scenes = scenes();
    scenes.truncate(1);
    for configuration in scenes[0]
        .measured
        .configurations
        .iter_mut()
        .filter(|configuration| !configuration.frontiers.is_empty())
    {
        configuration.frontiers.extend(Metric::ALL);
        configuration.dominated.clear();
    }
    assert!(page_of(&scenes, 0.05).contains("They do not: each configuration on one frontier"));
}

#[test]
fn the_same_scenes_give_the_same_bytes() {
    assert!(whole() == whole());
}

#[test]
fn style_and_script_cannot_end_early() {
    for raw in [include_str!("report.css"), include_str!("report.js")] {
        assert!(!raw.contains("</") && !raw.contains("<!--"));
    }
}

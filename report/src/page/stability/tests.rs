//! The page holds what was found.

use sglow_results::check::Check;

use crate::page::plot::Rank;
use crate::page::stability::extremes::summary;
use crate::page::stability::order::heat;
use crate::page::stability::*;

fn page_of(functions: &[FunctionReport], extremes: &[ExtremeReport]) -> String {
    let report = made_up::report();
    let findings = Findings {
        report: &report,
        functions,
        extremes,
        halves: &made_up::halves(),
        minutes: 3.25,
        does_not_show: &["how fast a GPU is & more"],
    };
    findings.page()
}

#[test]
fn every_section_is_there_and_nothing_comes_from_elsewhere() {
    let page = page_of(&made_up::functions(), &made_up::extremes());
    let titles = [
        "Error against time for the cosine forms",
        "What stability buys",
        "Functions",
        "Order of operations",
        "Extremes",
        "Half precision",
        "Bounds and their reasons",
        "What this does not show",
    ];
    let places = titles.map(|title| page.find(&format!("<h2>{title}</h2>")));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
    for word in ["http:", "https:", "<script", "src=", "@import", "url("] {
        assert!(!page.contains(word), "{word}");
    }
    let drawings: Vec<&str> =
        page.split("<svg").skip(1).filter_map(|rest| rest.split("</svg>").next()).collect();
    assert_eq!(drawings.len(), 2);
    for drawing in drawings {
        assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
    }
}

#[test]
fn what_fails_is_told_with_its_input() {
    let page = page_of(&made_up::functions(), &made_up::extremes());
    let verdict = page.find("check fails, 1 pass").unwrap();
    assert!(verdict < page.find("<h2>").unwrap(), "the verdict stands at the top");
    for part in ["not finite", "✗ FAILS", "0x42b20000", "how fast a GPU is &amp; more"] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn nothing_measured_is_no_success() {
    let page = page_of(&[], &[]);
    for part in ["None of the cosine forms", "was not tried", "Nothing was measured"] {
        assert!(page.contains(part), "{part}");
    }
    let report = Report::new();
    let empty = Findings {
        report: &report,
        functions: &[],
        extremes: &[],
        halves: &[],
        minutes: 0.0,
        does_not_show: &[],
    };
    assert!(empty.page().contains("Nothing was checked"));
}

#[test]
fn a_dominated_form_says_by_what_and_a_literal_one_does_not_count() {
    let forms = cosine_forms(&made_up::functions());
    let of = |name: &str| forms.spots.iter().find(|spot| spot.label == name).unwrap();
    assert_eq!(of("sg_cosine_gaussian").rank, Rank::Dominated);
    assert_eq!(of("sg_cosine_gaussian").aside, "dominated by logistic");
    assert_eq!(of("sg_cosine_constant").rank, Rank::Best);
    assert_eq!(of("sg_cosine_fitted").rank, Rank::Best);
    let literal = of("sg_cosine_logistic_literal");
    assert_eq!((literal.rank, literal.y.is_finite()), (Rank::Literal, false));
    assert!(of("sg_cosine_fitted").spread[0] < of("sg_cosine_fitted").x);
    assert!(forms.drawing().unwrap().file().starts_with("<svg"));
}

#[test]
fn without_what_times_are_relative_to_there_are_nanoseconds() {
    let mut functions = made_up::functions();
    functions.iter_mut().for_each(|function| function.relative_time = f64::NAN);
    let forms = cosine_forms(&functions);
    assert!(forms.x_label.starts_with("nanoseconds"));
    assert!(forms.spots.iter().all(|spot| spot.x.is_finite()));
}

#[test]
fn a_form_without_a_time_is_neither_drawn_nor_dominates_another() {
    let mut functions = made_up::functions();
    for function in &mut functions {
        function.relative_time = f64::NAN;
        if function.name == "sg_cosine_fitted_fine" {
            function.net = sglow_results::stability::held::Time::default();
        }
    }
    let forms = cosine_forms(&functions);
    assert!(forms.spots.iter().all(|spot| spot.label != "sg_cosine_fitted_fine"));
    assert!(forms.dominated.iter().all(|(_, by)| by != "sg_cosine_fitted_fine"));
    let page = page_of(&functions, &[]);
    assert!(
        page.contains("does not differ from that of reading arguments: sg_cosine_fitted_fine.")
    );
    functions.iter_mut().for_each(|function| function.net = Default::default());
    let page = page_of(&functions, &[]);
    assert!(page.contains("not drawn") && !page.contains("on the frontier"));
}

#[test]
fn a_variant_without_a_bound_is_summarised_apart() {
    let mut extremes = made_up::extremes();
    assert!(!summary(&extremes[0]).contains("without a bound"));
    extremes[0].variants[1].deviation = Some(0.5);
    let summary = summary(&extremes[0]);
    assert!(summary.contains("; 1 without a bound, largest deviation 0.500"), "{summary}");
}

#[test]
fn a_bound_from_below_is_called_so() {
    let mut report = made_up::report();
    report.check(Check::new("inputs", 3.0, "inputs", Relation::AtLeast, 1e7));
    let findings = Findings {
        report: &report,
        functions: &[],
        extremes: &[],
        halves: &[],
        minutes: 1.0,
        does_not_show: &[],
    };
    assert!(findings.page().contains("at least 10,000,000 inputs"));
}

#[test]
fn the_same_findings_give_the_same_bytes() {
    let page = || page_of(&made_up::functions(), &made_up::extremes());
    assert_eq!(page(), page());
}

#[test]
fn shades_tell_the_grant_apart_and_what_is_not_finite_is_the_darkest() {
    let shades = [0.05, 0.3, 1.0, 1.01, 1e3, f64::INFINITY].map(|share| heat(Some(share)));
    assert_eq!(shades, ["h0", "h1", "h2", "h3", "h4", "h5"]);
    assert_eq!(heat(Some(f64::NAN)), "h5");
}

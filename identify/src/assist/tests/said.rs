//! What is said of a study: headline, JSON, table, page.

use super::{case, fell, stood, swinging, swings, unknown};
use crate::assist::{Pair, Ridden, Study, headline, html, table};
use crate::figure::tests::check_well_formed;
use crate::spectrum::Recipe;
use serde_json::json;

/// A fall, a rise, a rescue and one that is thrown, on two trails and two loads.
fn study() -> Study {
    let up = || stood(swinging(0.1, 1.0, |_, _| 0.0));
    let cases: [(f64, f64, Pair<Ridden>); 4] = [
        (0.13, 0.0, swings(0.1, 0.05)),
        (0.13, 20.0, swings(0.05, 0.1)),
        (
            -0.035,
            0.0,
            Pair {
                without: fell(300),
                with: up(),
            },
        ),
        (
            -0.035,
            20.0,
            Pair {
                without: up(),
                with: fell(1200),
            },
        ),
    ];
    let worth = |(trail, load, pair): (f64, f64, Pair<Ridden>)| {
        crate::assist::worth(case(trail, load), &[pair], &Recipe::default(), &unknown())
            .expect("rides")
    };
    Study {
        controller: "A <controller>".into(),
        recipe: Recipe::default(),
        rows: cases.map(worth).to_vec(),
        notes: vec!["the rider leaves the course to the assist".into()],
    }
}

#[test]
fn the_headline_counts_and_names_the_harm() {
    assert_eq!(
        headline(&study()),
        [
            "With A <controller> the residual steering between 0.8 and 1.6 Hz falls in 1 of 4 cases, \
             rises in 1, does not change in 0, and cannot be compared in 2.",
            "It does harm where this band rises: trail 0.13 m, rear load 20 kg (to 2.00 of what it \
             was).",
            "It does harm where more rides fall with it than without: trail −0.035 m, rear load \
             20 kg (0 → 1 of 1 fell).",
            "Fewer rides fall with it than without: trail −0.035 m, rear load 0 kg (1 → 0 of 1 fell).",
            "Between 0.3 and 0.8 Hz it rises in 1 case.",
            "Between 1.6 and 3 Hz it rises in 1 case.",
        ]
        .map(|line| line.replace(" m,", "\u{a0}m,").replace(" kg", "\u{a0}kg"))
    );
}

#[test]
fn in_json_every_null_has_its_reason() {
    fn nulls(value: &serde_json::Value) -> usize {
        match value {
            serde_json::Value::Object(fields) => {
                let null = fields.values().any(serde_json::Value::is_null);
                assert!(!null || fields["reason"].is_string(), "{fields:?}");
                usize::from(null) + fields.values().map(nulls).sum::<usize>()
            }
            serde_json::Value::Array(items) => items.iter().map(nulls).sum(),
            _ => 0,
        }
    }
    let found = serde_json::to_value(study()).expect("JSON");
    let saved = &found["rows"][2];
    assert_eq!(saved["case"], json!({"trail": -0.035, "rear_load": 0.0}));
    assert_eq!(saved["outcome"], "saved");
    assert_eq!(
        saved["falls"]["without"]["median_time"],
        json!({"value": 3.0})
    );
    assert_eq!(
        found["rows"][0]["bands"][1]["change"]["value"]["verdict"],
        "falls"
    );
    // without: spectrum; with: time of falls; three bands, two ways, two closed loops
    assert_eq!(nulls(saved), 2 + 3 + 2 + 2);
    assert!(nulls(&found) > nulls(saved));
}

#[test]
fn table_and_page_have_every_case_and_every_reason() {
    let study = study();
    let text = table(&study);
    for said in [
        "trail 0.13 m, rear load 20 kg",
        "0.50 falls",
        "2.00 rises",
        "1 → 0 of 1 fell",
        "– Closed loop: the controller lists no states.",
        "note: the rider leaves the course to the assist",
    ] {
        assert!(text.contains(said), "{said} in\n{text}");
    }
    let page = html(&study, "wobble cosim --controller <X>.fmu");
    check_well_formed(&page);
    assert_eq!(page, html(&study, "wobble cosim --controller <X>.fmu"));
    for said in [
        "A &lt;controller&gt;",
        "<span class=\"verdict falls\">0.50 falls</span>",
        "<span class=\"verdict rises\">2.00 rises</span>",
        "<span class=\"verdict saved\">saved</span>",
        "<span class=\"verdict thrown\">thrown</span>",
        "The controller lists no states",
        "--controller &lt;X&gt;.fmu",
    ] {
        assert!(page.to_lowercase().contains(&said.to_lowercase()), "{said}");
    }
    assert!(
        !page.contains("<script") && !page.contains("http"),
        "needs something else"
    );
}

#[test]
fn a_study_without_cases_is_a_page_all_the_same() {
    let empty = Study {
        rows: vec![],
        ..study()
    };
    check_well_formed(&html(&empty, ""));
    assert!(headline(&empty)[0].contains("falls in 0 of 0 cases"));
    assert!(table(&empty).contains("case"));
}

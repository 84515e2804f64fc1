//! A power steering by disturbance observer as an FMU. The law and its variables are in
//! `disturbance_observer/model.rs`, what it shares with the other assist is in `assist`; its users
//! read `disturbance_observer/documentation`.

mod assist;
#[path = "disturbance_observer/model.rs"]
mod model;

use model::DisturbanceObserver;

fmi_export::export!(DisturbanceObserver);

#[test]
fn the_golden_file_is_up_to_date() {
    let xml = fmi_export::xml::<DisturbanceObserver>().expect("writable");
    expect_test::expect_file!["disturbance_observer.xml"].assert_eq(&xml);
}

//! A steering assist from roll angle and roll rate as an FMU. The law and its variables are in
//! `roll_assist/model.rs`, what it shares with the other assist is in `assist`; its users read
//! `roll_assist/documentation`.

mod assist;
#[path = "roll_assist/model.rs"]
mod model;

use model::RollAssist;

fmi_export::export!(RollAssist);

#[test]
fn the_golden_file_is_up_to_date() {
    let xml = fmi_export::xml::<RollAssist>().expect("writable");
    expect_test::expect_file!["roll_assist.xml"].assert_eq(&xml);
}

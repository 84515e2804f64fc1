//! The date of an archive: same input, same bytes.

use crate::Error;
use zip::DateTime;

/// The date that `SOURCE_DATE_EPOCH` gives (seconds since 1970, UTC), if it is set.
/// See <https://reproducible-builds.org/specs/source-date-epoch/>.
pub(crate) fn source_date() -> Result<Option<DateTime>, Error> {
    std::env::var("SOURCE_DATE_EPOCH")
        .ok()
        .map(|epoch| from_epoch(&epoch))
        .transpose()
}

fn from_epoch(epoch: &str) -> Result<DateTime, Error> {
    let refuse = || Error::Epoch {
        found: epoch.to_owned(),
    };
    let seconds: u64 = epoch.trim().parse().map_err(|_| refuse())?;
    // Years are counted from March, so that the leap day is the last of its year; 719468 days
    // lie between 0000-03-01 and 1970-01-01, 146097 days make 400 years.
    let day = seconds / 86_400 + 719_468;
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, carry) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    let year = u16::try_from(400 * era + year + carry).map_err(|_| refuse())?;
    let second = seconds % 86_400;
    // An archive knows no year before 1980.
    if year < 1980 {
        return Ok(DateTime::default());
    }
    DateTime::from_date_and_time(
        year,
        month as u8,
        day as u8,
        (second / 3600) as u8,
        (second / 60 % 60) as u8,
        (second % 60) as u8,
    )
    .map_err(|_| refuse())
}

/// As `xs:dateTime`.
pub(crate) fn iso(date: DateTime) -> String {
    format!(
        "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
        date.year(),
        date.month(),
        date.day(),
        date.hour(),
        date.minute(),
        date.second()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_dates() {
        let check = |epoch: &str, expected: &str| {
            assert_eq!(iso(from_epoch(epoch).expect("a date")), expected);
        };
        check("0", "1980-01-01T00:00:00Z");
        check("315532800", "1980-01-01T00:00:00Z");
        check("951782400", "2000-02-29T00:00:00Z");
        check("1709251198", "2024-02-29T23:59:58Z");
        check("1735689600", "2025-01-01T00:00:00Z");
        check("4107542400", "2100-03-01T00:00:00Z");
    }

    #[test]
    fn what_is_no_date_is_refused() {
        for epoch in ["", "tomorrow", "-1", "99999999999"] {
            assert!(from_epoch(epoch).is_err(), "{epoch}");
        }
    }
}

//! Stamps of loggers: dates and times of day, as `18.11.2026 10:14:32,000023` or `2026-11-18T10:14:32`.

/// The seconds since midnight of a stamp; 0 of a date alone.
pub(crate) fn seconds_of_day(cell: &str) -> Option<f64> {
    let mut parts = cell.split([' ', 'T']).filter(|part| !part.is_empty());
    let (first, second) = (parts.next()?, parts.next());
    if parts.next().is_some() {
        return None;
    }
    match second {
        Some(clock) if is_date(first) => seconds(clock),
        Some(_) => None,
        None if is_date(first) => Some(0.0),
        None => seconds(first),
    }
}

/// Day, month and year in any order, with one sign between them; the year may have two digits.
fn is_date(text: &str) -> bool {
    ['.', '-', '/'].into_iter().any(|sign| {
        let groups: Vec<&str> = text.split(sign).collect();
        let digits = groups.iter().all(|g| g.bytes().all(|b| b.is_ascii_digit()));
        let long = groups.iter().filter(|g| g.len() == 4).count();
        let short = groups.iter().filter(|g| (1..=2).contains(&g.len())).count();
        groups.len() == 3 && digits && long <= 1 && long + short == 3
    })
}

/// Hours, minutes and, if they are there, seconds with a fraction behind a point or a comma.
fn seconds(clock: &str) -> Option<f64> {
    let groups: Vec<&str> = clock.split(':').collect();
    let whole = |text: &str, most: u32| {
        let value: u32 = text.parse().ok()?;
        (text.len() <= 2 && value < most).then_some(f64::from(value))
    };
    let (hours, minutes) = (whole(groups[0], 24)?, whole(groups.get(1)?, 60)?);
    let last = match groups.get(2) {
        None => 0.0,
        Some(text) => {
            let digits = |b: u8| b.is_ascii_digit() || b == b'.' || b == b',';
            let value: f64 = text.replacen(',', ".", 1).parse().ok().filter(|_| text.bytes().all(digits))?;
            Some(value).filter(|v| *v < 61.0)?
        }
    };
    (groups.len() <= 3).then_some(3600.0 * hours + 60.0 * minutes + last)
}

#[cfg(test)]
mod tests {
    use super::seconds_of_day;

    #[test]
    fn exact_stamps_are_seconds_of_their_day() {
        for (stamp, seconds) in [
            ("18.11.2026 10:14:32,000023", 36_872.000_023),
            ("2026-11-18T10:14:32.5", 36_872.5),
            ("11/18/26 00:01", 60.0),
            ("23:59:59", 86_399.0),
            ("18.11.2026", 0.0),
        ] {
            assert_eq!(seconds_of_day(stamp), Some(seconds), "{stamp}");
        }
        for other in
            ["1.234.567", "1.5", "10:14:32 x", "25:00", "10:61", "a:b", "18.11.2026 12", "1-2", "", "1:2:3:4"]
        {
            assert_eq!(seconds_of_day(other), None, "{other}");
        }
    }
}

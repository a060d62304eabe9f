//! What can go wrong, with numbers.

/// Why the flow has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlowError {
    /// A temperature that is not a positive number of kelvin.
    #[error("the temperature at x = {x} m is {kelvin} K; it must be positive (give kelvin, not Celsius)")]
    Temperature {
        /// Where, m.
        x: f64,
        /// The value.
        kelvin: f64,
    },
    /// A temperature at which the properties of the gas do not hold.
    #[error(
        "{what} is {kelvin} K; the properties of air hold from {low} to {high} K (give kelvin, not Celsius)"
    )]
    Range {
        /// Which temperature.
        what: String,
        /// The value, K.
        kelvin: f64,
        /// Lowest at which they hold, K.
        low: f64,
        /// Highest, K.
        high: f64,
    },
    /// A profile whose lists do not fit together.
    #[error(
        "a base state needs at least two ascending places with one temperature each and a positive pressure; \
         it has {places} places and {temperatures} temperatures"
    )]
    Profile {
        /// Number of places.
        places: usize,
        /// Number of temperatures.
        temperatures: usize,
    },
    /// A heater that does not fit into the tube.
    #[error(
        "the heater's centre is at {position} m; it must lie between {low} and {high} m to fit into the tube"
    )]
    Heater {
        /// Its centre, m.
        position: f64,
        /// Lowest place, m.
        low: f64,
        /// Highest place, m.
        high: f64,
    },
    /// A closure out of its range.
    #[error("the closure {name} is {value}, but must be {need}")]
    Closure {
        /// Its key.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        need: &'static str,
    },
    /// Readings that no flow fits with closures that can be.
    #[error(
        "the readings pull the closure {name} to {value:.6}, and it must be {need}: no flow fits them with what is known of the tube"
    )]
    Pulled {
        /// Key of the closure.
        name: &'static str,
        /// Where the search went.
        value: f64,
        /// What it must be.
        need: &'static str,
    },
    /// A power that is negative or not finite.
    #[error("the heater power is {watts} W; it must be zero or positive")]
    Power {
        /// The value.
        watts: f64,
    },
    /// No mass flow balances buoyancy and losses, as when temperatures have left the range of the gas.
    #[error(
        "no mass flow balances buoyancy and losses; the walls lie between {coldest:.1} and {hottest:.1} K"
    )]
    NoFlow {
        /// Lowest wall temperature, K.
        coldest: f64,
        /// Highest wall temperature, K.
        hottest: f64,
    },
    /// Newton's iteration for the steady state did not converge.
    #[error(
        "the steady state was not found in {steps} steps; the largest imbalance is {residual:.3e} of the power"
    )]
    NotSteady {
        /// Steps taken.
        steps: usize,
        /// Largest heat imbalance over the power.
        residual: f64,
    },
    /// A prior that has no normal score here.
    #[error("the prior of {name} must be uniform, normal or log-normal")]
    Prior {
        /// Name of the unknown.
        name: String,
    },
    /// A record that starts with the heater on.
    #[error(
        "the first sample was taken at {watts} W: start with samples at 0 W and ambient temperature, which calibrate \
         the constant errors of the channels"
    )]
    NotCalibrated {
        /// Power of the first sample, W.
        watts: f64,
    },
    /// Fewer readings than unknowns.
    #[error("{have} readings cannot fix {need} unknowns; add samples or sensors")]
    TooFewSamples {
        /// Readings in all.
        have: usize,
        /// Unknowns.
        need: usize,
    },
    /// More samples than any run needs.
    #[error(
        "{have} samples are more than the {most} that are read: give samples at longer intervals, and check whether a row was repeated"
    )]
    TooManySamples {
        /// Samples of the run.
        have: usize,
        /// Most that are read.
        most: usize,
    },
    /// A sample whose readings are not as many as the sensors, or not finite.
    #[error("sample {index} has {got} readings for {need} sensors, or one of them is not a number")]
    Readings {
        /// Number of the sample, from 0.
        index: usize,
        /// Readings given.
        got: usize,
        /// Sensors.
        need: usize,
    },
    /// A number about the record as a whole that is out of range.
    #[error("{name} = {value}; it must be {must}")]
    Setting {
        /// Its key.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A sample that cannot be used.
    #[error("sample {index}: {source}")]
    Sample {
        /// Number of the sample, from 0.
        index: usize,
        /// Why.
        source: Box<FlowError>,
    },
    /// An operating point that cannot be used.
    #[error("operating point {id}: {source}")]
    Point {
        /// Its name.
        id: String,
        /// Why.
        source: Box<FlowError>,
    },
    /// A reading that no sensor has.
    #[error("{what} is {value}; it must be {must}")]
    Reading {
        /// Of what.
        what: String,
        /// The value.
        value: f64,
        /// What it may be.
        must: &'static str,
    },
    /// A reading that the model misses by far, whatever the unknowns.
    #[error(
        "operating point {id}: the {sensor} reads {reading:.6e}, and the model has {model:.6e}, both in SI units: no flow fits the readings of this place of the heater"
    )]
    FarOff {
        /// Operating point.
        id: String,
        /// The file that has the reading.
        file: &'static str,
        /// Of what.
        sensor: String,
        /// The reading.
        reading: f64,
        /// What the model has before the fit.
        model: f64,
    },
    /// A run over time whose points have two thermometers.
    #[error(
        "operating points {first} and {second} are of one ramp and have different days or ambient temperatures; a ramp is one run \
         that starts at one temperature, so give both the day and the temperature at its start"
    )]
    TwoDays {
        /// The first point.
        first: String,
        /// The one that differs.
        second: String,
    },
    /// A sensor outside the tube, or with noise that no sensor has.
    #[error(
        "the {sensor} lies outside the tube, or its standard deviations are impossible: `sd` must be from 1e-8 to 1 s, or from 0.001 to 1000 K or m/s, and `bias_sd` from zero on"
    )]
    Sensor {
        /// The sensor.
        sensor: String,
    },
    /// The inference failed.
    #[error("the fit failed: {0}")]
    Inference(String),
    /// The ensemble failed.
    #[error(transparent)]
    Ensemble(#[from] rijke_inference::ensemble::EnsembleError),
    /// A covariance that is not positive definite.
    #[error(transparent)]
    Dense(#[from] rijke_numerics::DenseError),
    /// A file that cannot be read or written.
    #[error("{}: {problem}", file.display())]
    File {
        /// The file.
        file: std::path::PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A line of a file whose numbers cannot be used.
    #[error("{}: line {line}: {source}", file.display())]
    InLine {
        /// The file.
        file: std::path::PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Why.
        source: Box<FlowError>,
    },
    /// A run that cannot be used.
    #[error("{}: {source}", file.display())]
    InRun {
        /// The file of its samples.
        file: std::path::PathBuf,
        /// Why.
        source: Box<FlowError>,
    },
}

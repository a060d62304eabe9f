//! What is said of the heat of a stream by its thermometers.

use rijke_numerics::Tell;
use rijke_numerics::words::{rounded, with_sd};
use rijke_study::HeatedFit;

/// Says it.
pub fn tell_heat(heat: &HeatedFit, tell: &dyn Tell) {
    tell.note(format!(
        "the gas gets {} of the power, and gives {} W/(m^2 K) to the wall, by the readings",
        with_sd(heat.share[0], heat.share[1]),
        with_sd(heat.cooling[0], heat.cooling[1])
    ));
    if let Some([ratio, sd]) = heat.near {
        tell.note(format!("one diameter behind the part it gives {} times that", with_sd(ratio, sd)));
    }
    tell.note(format!(
        "the rise of the gas scatters from point to point by {:.2} % (root mean square of the posterior; 95 % of it from {:.2} to {:.2} %)",
        100.0 * heat.scatter,
        100.0 * heat.scatter_within[0],
        100.0 * heat.scatter_within[1]
    ));
    let [offset, sd, before] = heat.common;
    if before > 0.0 && !heat.thermometers.is_empty() {
        tell.note(format!(
            "the thermometers together read {} K too much, by readings and heat (0 +- {} before them)",
            with_sd(offset, sd),
            rounded(before)
        ));
    }
    tell.warn(&heat.warnings());
}

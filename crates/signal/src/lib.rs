//! From raw microphone records to pings and clicks with uncertainties.

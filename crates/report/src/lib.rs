//! Numbers to SVG, CSV and HTML.

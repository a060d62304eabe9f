//! Table 1: the campaign as it was read, record by record.

use crate::{Check, Provenance, RejectedRecord};
use rijke_rig::{Campaign, Observations, OperatingPoint, PointObservations};
use serde::{Deserialize, Serialize};

/// Table 1: how many experiments there are at each operating point, and how many of them are used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CampaignRead {
    /// All operating points, all pings used, all records not used.
    pub provenance: Provenance,
    /// Number of clicks used.
    pub clicks: u64,
    /// The rows, in the order of the campaign.
    pub rows: Vec<CampaignRow>,
    /// The statements of the text.
    pub checks: Vec<Check>,
}

/// One row of the campaign: one configuration of the rig at one power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CampaignRow {
    /// Name of the row.
    pub id: String,
    /// Whether the heater is attached.
    pub heater: bool,
    /// Whether the thermocouples are in place.
    pub thermocouples: bool,
    /// Electrical power, W.
    pub power_w: f64,
    /// The operating points of the row.
    pub points: Vec<PointRead>,
}

/// One operating point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointRead {
    /// Name of the point.
    pub id: String,
    /// Where heater or prongs sit, m; none for the empty tube.
    pub position_m: Option<f64>,
    /// Number of experiments recorded.
    pub recorded: u32,
    /// The number in the paper's table, where it has this point.
    pub published: Option<u32>,
    /// Number of pings used.
    pub pings: u32,
    /// Number of clicks used.
    pub clicks: u32,
    /// Mean growth rate of the first mode, 1/s; none without a usable ping.
    pub growth_rate: Option<f64>,
    /// Mean angular frequency of the first mode, rad/s.
    pub angular_frequency: Option<f64>,
}

/// Counts what was observed and compares the operating points with the paper's Table 1.
#[must_use]
pub fn campaign(observations: &Observations) -> CampaignRead {
    let published = Campaign::juniper_yoko_2022();
    let mut rows: Vec<CampaignRow> = Vec::new();
    for observed in &observations.points {
        let point = &observed.point;
        if rows.last().is_none_or(|row| row.id != point.row) {
            rows.push(CampaignRow {
                id: point.row.clone(),
                heater: false,
                thermocouples: false,
                power_w: point.power,
                points: Vec::new(),
            });
        }
        if let Some(row) = rows.last_mut() {
            // The empty tube of a row has neither heater nor prongs.
            row.heater |= point.heater;
            row.thermocouples |= point.thermocouples;
            row.points.push(read(observed, &published));
        }
    }
    let sum = |count: fn(&PointObservations) -> u32| {
        observations.points.iter().map(|p| u64::from(count(p))).sum::<u64>()
    };
    let rejected = observations
        .rejections
        .iter()
        .map(|r| RejectedRecord { record: r.record.clone(), reason: r.reason.clone() });
    CampaignRead {
        provenance: Provenance {
            data: observations.kind,
            rig: observations.rig.name.clone(),
            source: observations.source.clone(),
            points: observations.points.len(),
            pings: sum(|p| p.ping_count),
            rejected: rejected.collect(),
        },
        clicks: sum(|p| p.click_count),
        checks: checks(&rows),
        rows,
    }
}

fn read(observed: &PointObservations, published: &Campaign) -> PointRead {
    let point = &observed.point;
    let same = |p: &&OperatingPoint| {
        let near = match (p.position, point.position) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-6,
            (a, b) => a.is_none() && b.is_none(),
        };
        near && p.row == point.row && p.power == point.power && p.thermocouples == point.thermocouples
    };
    PointRead {
        id: point.id.clone(),
        position_m: point.position,
        recorded: point.repeats,
        published: published.points.iter().find(same).map(|p| p.repeats),
        pings: observed.ping_count,
        clicks: observed.click_count,
        growth_rate: observed.ping.as_ref().map(|p| p.s.re),
        angular_frequency: observed.ping.as_ref().map(|p| p.s.im),
    }
}

/// The first sentence of the paper's abstract: "7000 experiments at 175 stable operating points".
fn checks(rows: &[CampaignRow]) -> Vec<Check> {
    let points: Vec<&PointRead> = rows.iter().flat_map(|r| &r.points).collect();
    let total = Campaign::juniper_yoko_2022().points.len();
    let found = points.iter().filter(|p| p.published.is_some()).count();
    let experiments: u32 = points.iter().map(|p| p.recorded).sum();
    let whole = points.iter().all(|p| p.published == Some(p.recorded)) && found == total;
    let highest =
        points.iter().filter_map(|p| p.growth_rate.map(|g| (g, *p))).max_by(|a, b| a.0.total_cmp(&b.0));
    let mut checks = vec![Check {
        statement: "The campaign is that of Table 1: 7000 experiments at 175 operating points.".into(),
        holds: whole,
        figure: format!("{experiments} experiments at {found} of its {total} operating points"),
        explanation: (!whole).then(|| "This is a shortened run, or another campaign.".to_owned()),
    }];
    if let Some((growth, point)) = highest {
        checks.push(Check {
            statement: "All operating points are stable.".into(),
            holds: growth < 0.0,
            figure: format!("the highest mean growth rate is {growth:.2} 1/s, at {}", point.id),
            explanation: None,
        });
    }
    checks
}

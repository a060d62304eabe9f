//! Where a law acts.

/// A kind of place of the rig; the operating point says where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Along a duct, or along all of them.
    Duct(Option<usize>),
    /// Along an insert; the law is a coefficient per metre.
    Along(usize),
    /// Where an insert or a duct begins.
    Start(usize),
    /// Where an insert or a duct ends.
    End(usize),
    /// Every place of a device, with the whole law at each.
    Each(usize),
    /// Every place of a device, with an equal share of the law at each.
    Shared(usize),
    /// The mean of the places of a device, all of the law at once.
    Middle(usize),
    /// The upstream end.
    Upstream,
    /// The downstream end.
    Downstream,
    /// Both ends alike.
    Ends,
}

impl Place {
    /// Whether the law is a coefficient per metre.
    #[must_use]
    pub fn is_along(&self) -> bool {
        matches!(self, Self::Duct(_) | Self::Along(_))
    }

    /// Whether it is an end of the rig.
    #[must_use]
    pub fn is_end(&self) -> bool {
        matches!(self, Self::Upstream | Self::Downstream | Self::Ends)
    }

    /// Whether it is along ducts themselves, so that the law is that of their wall.
    #[must_use]
    pub fn is_duct(&self) -> bool {
        matches!(self, Self::Duct(_))
    }

    /// The part, if it is one.
    #[must_use]
    pub fn part(&self) -> Option<usize> {
        match *self {
            Self::Duct(part) => part,
            Self::Along(k)
            | Self::Start(k)
            | Self::End(k)
            | Self::Each(k)
            | Self::Shared(k)
            | Self::Middle(k) => Some(k),
            Self::Upstream | Self::Downstream | Self::Ends => None,
        }
    }
}

//! Training on responses, against closed forms and against likelihoods that are written out.

mod bench;
mod bent;
mod chain;
mod channels;
mod delay;
mod extends;
mod head;
mod nodes;
mod noise;
mod pressures;
mod slow;
mod stated;
mod temperatures;

//! Chosen candidates, flow and network as one trainable, savable, predicting model.

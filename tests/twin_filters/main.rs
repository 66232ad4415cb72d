//! The filters of the picture on the GPU, each pass against its formula on the CPU: edges, the interleaving blur and the
//! à-trous wavelet. Each starts from what the GPU made before it, so that a fault shows in its own pass.

mod atrous;
#[path = "../common/mod.rs"]
mod common;
mod interleave;

//! A frame that counts frames: it adds one to what the frame before left, in a buffer and in an image.

use gridlight::gpu::{Executor, TransferOp, Work};
use gridlight::graph::{Access, BufferHandle, Graph, History, ImageHandle, ImageInfo, Pass};
use gridlight::passes::{shader, threads};

use super::GpuTest;

/// The frame, and the two counts that it keeps.
pub struct Counter {
    pub executor: Executor,
    pub count: History<BufferHandle>,
    pub image: History<ImageHandle>,
    level: u32,
}

impl Counter {
    /// Counts in one level of an image.
    pub fn new(gpu: &GpuTest, info: ImageInfo, level: u32) -> Self {
        let mut graph = Graph::new();
        let constants = graph.transient_buffer("constants", 16);
        let count = graph.history_buffer("count", 4);
        let image = graph.history_image("count_image", info);
        let setup = Work::Transfer(vec![TransferOp::FrameData { buffer: constants }]);
        graph.add_pass(Pass::new("setup", setup).uses(constants, Access::TransferWrite));
        let count_pass = Pass::new("count_frames", Work::Compute(shader("tests/count_frames", threads(1))))
            .bind("constants", constants, Access::ComputeUniform)
            .bind("previous_count", count.previous, Access::ComputeRead)
            .bind("count", count.current, Access::ComputeWrite)
            .bind("previous_count_image", image.previous.level(level), Access::ComputeSampled)
            .bind("count_image", image.current.level(level), Access::ComputeWrite);
        graph.add_pass(count_pass);
        Self { executor: Executor::new(&gpu.gpu, graph, None).unwrap(), count, image, level }
    }

    /// What a frame must be told.
    pub fn constants(&self) -> [u32; 4] {
        [u32::from(self.executor.history_is_valid()), 0, 0, 0]
    }

    /// Runs so many frames, two in flight, and gives both counts.
    pub fn run(&mut self, frames: u32) -> [u32; 2] {
        let mut before = None;
        for _ in 0..frames {
            let constants = self.constants();
            let ticket = self.executor.submit(bytemuck::cast_slice(&constants)).unwrap();
            if let Some(before) = before.replace(ticket) {
                self.executor.wait(before).unwrap();
            }
        }
        if let Some(last) = before {
            self.executor.wait(last).unwrap();
        }
        self.counts(self.count.current, self.image.current)
    }

    /// What one of the buffers and one of the images hold.
    pub fn counts(&self, buffer: BufferHandle, image: ImageHandle) -> [u32; 2] {
        let word = |bytes: Vec<u8>| bytemuck::pod_read_unaligned(&bytes[..4]);
        let texels = self.executor.read_image(image.level(self.level)).unwrap();
        [word(self.executor.read_buffer(buffer).unwrap()), word(texels)]
    }
}

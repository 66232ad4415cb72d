//! A frame run pass by pass, with what every pass left behind.

use std::collections::BTreeMap;

use gridlight::gpu::Executor;
use gridlight::renderer::Renderer;
use gridlight::shared::FrameData;

/// What each pass has written, by the names of pass and resource.
pub struct Written {
    by_pass: BTreeMap<(String, String), Vec<u8>>,
    /// What the last pass that wrote to a resource left there.
    last: BTreeMap<String, Vec<u8>>,
}

impl Written {
    /// One frame of a renderer.
    pub fn by(renderer: &Renderer) -> Self {
        Self::by_graph(renderer.executor(), renderer.frame_data())
    }

    /// One run of a graph.
    pub fn by_graph(executor: &Executor, data: &FrameData) -> Self {
        let (passes, resources) = (executor.graph().passes(), executor.graph().resources());
        let (mut by_pass, mut last) = (BTreeMap::new(), BTreeMap::new());
        executor
            .run_and_read(bytemuck::bytes_of(data), |pass, left| {
                for left in left {
                    let resource = &resources[left.resource].name;
                    last.insert(resource.clone(), left.bytes.clone());
                    by_pass.insert((passes[pass].name.clone(), resource.clone()), left.bytes);
                }
                Ok(())
            })
            .unwrap();
        Self { by_pass, last }
    }

    /// What `pass` left in `resource`.
    pub fn all<T: bytemuck::Pod>(&self, pass: &str, resource: &str) -> Vec<T> {
        let bytes = self.by_pass.get(&(pass.to_owned(), resource.to_owned()));
        bytemuck::pod_collect_to_vec(bytes.unwrap_or_else(|| panic!("{pass} leaves no {resource}")))
    }

    /// What `resource` held in the end.
    pub fn last<T: bytemuck::Pod>(&self, resource: &str) -> Vec<T> {
        let bytes = self.last.get(resource);
        bytemuck::pod_collect_to_vec(bytes.unwrap_or_else(|| panic!("nothing writes {resource}")))
    }

    /// What `pass` left in `resource`, where the frame has such a pass and resource.
    pub fn get<T: bytemuck::Pod>(&self, pass: &str, resource: &str) -> Option<Vec<T>> {
        self.by_pass.get(&(pass.to_owned(), resource.to_owned())).map(|bytes| bytemuck::pod_collect_to_vec(bytes))
    }
}

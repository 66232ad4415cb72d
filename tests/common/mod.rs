//! What the tests on a GPU share: one device per test binary, lights, the hierarchy alone.

#![allow(dead_code, reason = "every test binary uses another part")]

pub mod compare;
pub mod counter;
pub mod frames;
pub mod hierarchy;
pub mod light_sets;
pub mod picture;
pub mod points;
pub mod rooms;
pub mod written;

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use gridlight::gpu::{Gpu, GpuOptions};

/// The device of this test binary, for one test at a time: its queue belongs to one thread.
pub struct GpuTest {
    /// The device, with core and synchronization validation where the layer is installed.
    pub gpu: Arc<Gpu>,
    _guard: MutexGuard<'static, ()>,
}

/// Waits for the device. A machine without any Vulkan driver fails: a software driver is a requirement.
pub fn gpu() -> GpuTest {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let guard = lock();
    let gpu = GPU.get_or_init(|| open(false)).clone();
    GpuTest { gpu, _guard: guard }
}

/// The same with every optional feature treated as missing.
pub fn baseline_gpu() -> GpuTest {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let guard = lock();
    let gpu = GPU.get_or_init(|| open(true)).clone();
    GpuTest { gpu, _guard: guard }
}

fn lock() -> MutexGuard<'static, ()> {
    static IN_USE: Mutex<()> = Mutex::new(());
    IN_USE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn open(baseline_only: bool) -> Arc<Gpu> {
    let options = GpuOptions { validation: true, baseline_only, ..GpuOptions::default() };
    Gpu::new(&options).unwrap_or_else(|error| {
        eprintln!("without validation: {error}");
        let options = GpuOptions { validation: false, ..options };
        Gpu::new(&options).expect("these tests need a Vulkan 1.3 driver; lavapipe will do")
    })
}

impl Drop for GpuTest {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let messages = self.gpu.validation_messages();
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}

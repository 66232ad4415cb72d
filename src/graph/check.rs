//! What can be wrong with a declared frame, found before any barrier is planned.

use std::collections::{HashMap, HashSet};

use super::access::{Access, SyncScope};
use super::builder::{BindingName, Graph, Pass, Use};
use super::resource::{Handle, ImageDepth, Lifetime, Resource, ResourceInfo};

/// Why a frame cannot be planned.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// Two passes share a name.
    #[error("two passes are called `{pass}`")]
    DuplicatePass {
        /// The shared name.
        pass: String,
    },
    /// Two resources share a name.
    #[error("two resources are called `{resource}`")]
    DuplicateResource {
        /// The shared name.
        resource: String,
    },
    /// A buffer of 0 bytes, or an image without texels, layers or levels.
    #[error("resource `{resource}` has no size")]
    ZeroSize {
        /// The resource.
        resource: String,
    },
    /// More mip levels than it takes to come down to one texel.
    #[error("image `{resource}` has {level_count} levels, but only {most} fit its size")]
    TooManyLevels {
        /// The image.
        resource: String,
        /// Its levels.
        level_count: u32,
        /// The most that fit.
        most: u32,
    },
    /// A mip level that the resource does not have.
    #[error("pass `{pass}` uses level {level} of `{resource}`, which has {level_count}")]
    UnknownLevel {
        /// The pass.
        pass: String,
        /// The resource.
        resource: String,
        /// The level.
        level: u32,
        /// How many there are.
        level_count: u32,
    },
    /// A use that takes one level, of an image that has several.
    #[error("pass `{pass}` uses `{resource}` as {access:?}, which takes one of its levels")]
    LevelNotNamed {
        /// The pass.
        pass: String,
        /// The image.
        resource: String,
        /// The access.
        access: Access,
    },
    /// An array or an image of three dimensions as an attachment.
    #[error("pass `{pass}` uses `{resource}` as {access:?}, but only flat images can be attachments")]
    AttachmentNotFlat {
        /// The pass.
        pass: String,
        /// The image.
        resource: String,
        /// The access.
        access: Access,
    },
    /// A handle that no resource of this graph answers to.
    #[error("pass `{pass}` uses resource number {index}, which this graph does not have")]
    UnknownResource {
        /// The pass.
        pass: String,
        /// The handle's index.
        index: usize,
    },
    /// Two resources at one descriptor binding.
    #[error("pass `{pass}` attaches `{resource}` at binding {binding}, which is already taken")]
    DuplicateBinding {
        /// The pass.
        pass: String,
        /// The resource attached second.
        resource: String,
        /// The binding.
        binding: BindingName,
    },
    /// An access that the kind of resource does not allow.
    #[error("pass `{pass}` uses `{resource}` as {access:?}, which does not fit that kind of resource")]
    DoesNotFit {
        /// The pass.
        pass: String,
        /// The resource.
        resource: String,
        /// The access.
        access: Access,
    },
    /// A write to what the frame before left.
    #[error("pass `{pass}` writes `{resource}`, which belongs to the frame before")]
    WriteToPrevious {
        /// The pass.
        pass: String,
        /// The resource.
        resource: String,
    },
    /// A pair that changes places between frames, whose current one stays as it was two frames ago.
    #[error("no pass writes `{resource}`, which the next frame has as its previous one")]
    HistoryNotWritten {
        /// The resource.
        resource: String,
    },
    /// Contents read that no earlier pass of the frame wrote.
    #[error("pass `{pass}` reads `{resource}`, which no earlier pass of the frame wrote")]
    ReadBeforeWrite {
        /// The pass.
        pass: String,
        /// The resource.
        resource: String,
    },
    /// Two accesses of one pass that need the image in different layouts.
    #[error("pass `{pass}` uses `{resource}` as {first:?} and as {second:?}, which need different layouts")]
    Conflict {
        /// The pass.
        pass: String,
        /// The resource.
        resource: String,
        /// The access declared first.
        first: Access,
        /// The access that disagrees with it.
        second: Access,
    },
}

impl From<PlanError> for crate::Error {
    fn from(error: PlanError) -> Self {
        Self::Failure(format!("the frame graph is wrong: {error}"))
    }
}

/// Everything one pass does with one level of an image, or with a buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    pub resource: Handle,
    pub level: u32,
    pub scope: SyncScope,
    pub reads: bool,
    pub writes: bool,
    first: Access,
}

/// Checks the whole graph and gives, per pass, its uses merged by resource and level in order of declaration.
pub(super) fn check<P>(graph: &Graph<P>) -> Result<Vec<Vec<Need>>, PlanError> {
    let mut names = HashSet::new();
    for resource in graph.resources() {
        if !names.insert(&resource.name) {
            return Err(PlanError::DuplicateResource { resource: resource.name.clone() });
        }
        if resource.lifetime != Lifetime::Imported {
            check_size(resource)?;
        }
    }
    let mut names = HashSet::new();
    let mut written = HashSet::new();
    let mut all = Vec::new();
    for pass in graph.passes() {
        if !names.insert(&pass.name) {
            return Err(PlanError::DuplicatePass { pass: pass.name.clone() });
        }
        let needs = merge_uses(pass, graph.resources())?;
        for need in &needs {
            let resource = &graph.resources()[need.resource.index()];
            if resource.lifetime.starts_empty() && need.reads && !written.contains(&(need.resource, need.level)) {
                return Err(PlanError::ReadBeforeWrite { pass: pass.name.clone(), resource: resource.name.clone() });
            }
        }
        written.extend(needs.iter().filter(|need| need.writes).map(|need| (need.resource, need.level)));
        all.push(needs);
    }
    history_written(graph, &all, &written)?;
    Ok(all)
}

fn check_size(resource: &Resource) -> Result<(), PlanError> {
    let name = || resource.name.clone();
    match resource.info {
        ResourceInfo::Buffer(info) if info.size_bytes == 0 => Err(PlanError::ZeroSize { resource: name() }),
        ResourceInfo::Image(info) if info.is_empty() => Err(PlanError::ZeroSize { resource: name() }),
        ResourceInfo::Image(info) if info.level_count > info.most_levels() => {
            Err(PlanError::TooManyLevels { resource: name(), level_count: info.level_count, most: info.most_levels() })
        }
        _ => Ok(()),
    }
}

/// Of every pair in use the current one must be written, each level that is used.
fn history_written<P>(
    graph: &Graph<P>,
    needs: &[Vec<Need>],
    written: &HashSet<(Handle, u32)>,
) -> Result<(), PlanError> {
    for need in needs.iter().flatten() {
        let current = match graph.resources()[need.resource.index()].lifetime {
            Lifetime::Previous { current } => current,
            Lifetime::Current { .. } => need.resource,
            _ => continue,
        };
        if !written.contains(&(current, need.level)) {
            return Err(PlanError::HistoryNotWritten { resource: graph.resources()[current.index()].name.clone() });
        }
    }
    Ok(())
}

fn merge_uses<P>(pass: &Pass<P>, resources: &[Resource]) -> Result<Vec<Need>, PlanError> {
    let mut bindings = HashSet::new();
    let mut needs: Vec<Need> = Vec::new();
    let mut slots = HashMap::new();
    for used in &pass.uses {
        let index = used.resource.index();
        let Some(resource) = resources.get(index) else {
            return Err(PlanError::UnknownResource { pass: pass.name.clone(), index });
        };
        check_use(&pass.name, resource, used)?;
        if let Some(binding) = used.binding.filter(|&binding| !bindings.insert(binding)) {
            let (pass, resource) = (pass.name.clone(), resource.name.clone());
            return Err(PlanError::DuplicateBinding { pass, resource, binding });
        }
        let scope = used.access.sync(resource.info.kind());
        let (reads, writes) = (used.access.is_read(), used.access.is_write());
        for level in resource.info.levels(used.level) {
            let slot = *slots.entry((used.resource, level)).or_insert(needs.len());
            let Some(need) = needs.get_mut(slot) else {
                needs.push(Need { resource: used.resource, level, scope, reads, writes, first: used.access });
                continue;
            };
            if need.scope.layout != scope.layout {
                let (pass, resource) = (pass.name.clone(), resource.name.clone());
                return Err(PlanError::Conflict { pass, resource, first: need.first, second: used.access });
            }
            need.scope.stages |= scope.stages;
            need.scope.access |= scope.access;
            need.reads |= reads;
            need.writes |= writes;
        }
    }
    Ok(needs)
}

/// Whether a resource can be used this way.
fn check_use(pass: &str, resource: &Resource, used: &Use) -> Result<(), PlanError> {
    let (pass, access) = (pass.to_owned(), used.access);
    let (name, level_count) = (resource.name.clone(), resource.info.level_count());
    if !access.fits(resource.info.kind()) {
        return Err(PlanError::DoesNotFit { pass, resource: name, access });
    }
    if matches!(resource.lifetime, Lifetime::Previous { .. }) && access.is_write() {
        return Err(PlanError::WriteToPrevious { pass, resource: name });
    }
    if let Some(level) = used.level.filter(|level| *level >= level_count) {
        return Err(PlanError::UnknownLevel { pass, resource: name, level, level_count });
    }
    if used.level.is_none() && level_count > 1 && !access.takes_levels() {
        return Err(PlanError::LevelNotNamed { pass, resource: name, access });
    }
    match resource.info {
        ResourceInfo::Image(info) if access.is_attachment() && info.depth != ImageDepth::Flat => {
            Err(PlanError::AttachmentNotFlat { pass, resource: name, access })
        }
        _ => Ok(()),
    }
}

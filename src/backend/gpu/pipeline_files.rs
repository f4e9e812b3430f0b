//! Compiled pipelines on disk, a file each, so that only a scene's first picture waits for the driver's compiler.
//!
//! Many drivers keep such files themselves, but not everywhere (benches/results/accel_h100.md). The folder is `rayloom/pipelines` among the
//! user's caches, or what `RAYLOOM_PIPELINES` names; empty, it turns this off. A file that cannot be read or written costs time alone.
//!
//! One of the places with unsafe code: wgpu asks for data that it gave out itself. A checksum before the data finds files that were cut off,
//! wgpu looks at the device and the driver's version, and the driver at the shaders.
#![allow(unsafe_code)]

use crate::film::replace_file;
use crate::film::state::checksum;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Bytes that the files of one device may take; the oldest go.
const MAX_BYTES: u64 = 256 << 20;
/// Bytes of the checksum.
const HEAD: usize = 8;
const VARIABLE: &str = "RAYLOOM_PIPELINES";

/// The folder of one device's pipelines.
#[derive(Debug)]
pub(super) struct PipelineFiles {
    folder: PathBuf,
}

/// A pipeline's file, before and after it is compiled.
pub(super) struct PipelineFile<'f> {
    files: &'f PipelineFiles,
    path: PathBuf,
    is_new: bool,
    /// For `ComputePipelineDescriptor::cache`.
    pub cache: wgpu::PipelineCache,
}

impl PipelineFiles {
    /// `None` where the device does not give its pipelines out, there is no folder, or the user wants none. Renderers in software have them
    /// only where a folder is named: their pipelines are of the machine.
    pub fn new(device: &wgpu::Device, info: &wgpu::AdapterInfo) -> Option<Self> {
        let named = std::env::var_os(VARIABLE);
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) || named.is_none() && info.device_type == wgpu::DeviceType::Cpu {
            return None;
        }
        let folder = match named {
            Some(folder) if folder.is_empty() => return None,
            Some(folder) => PathBuf::from(folder),
            None => crate::user_folders::cache()?.join("pipelines"),
        };
        Some(Self { folder: folder.join(wgpu::util::pipeline_cache_key(info)?) })
    }

    /// The file of the pipeline that this text and entry point make.
    pub fn file(&self, device: &wgpu::Device, text: &str, entry_point: &str) -> PipelineFile<'_> {
        let name = format!("{:016x}{:016x}", checksum(text.as_bytes()), checksum(entry_point.as_bytes()));
        let path = self.folder.join(name);
        let data = read(&path);
        let descriptor = wgpu::PipelineCacheDescriptor { label: None, data: data.as_deref(), fallback: true };
        // SAFETY: the data is what `PipelineCache::get_data` gave, as far as a checksum tells.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        PipelineFile { files: self, path, is_new: data.is_none(), cache }
    }
}

impl PipelineFile<'_> {
    /// Writes the compiled pipeline, where it was not read. What fails is left: the next run compiles again.
    pub fn keep(self) {
        if !self.is_new {
            return;
        }
        if let Some(data) = self.cache.get_data() {
            let _ = write(&self.path, &data).and_then(|()| make_room(&self.files.folder, MAX_BYTES));
        }
    }
}

/// What [`write`] wrote; `None` when it is not there or not whole. Marks it as used.
fn read(path: &Path) -> Option<Vec<u8>> {
    let mut bytes = std::fs::read(path).ok()?;
    let head = u64::from_le_bytes(bytes.get(..HEAD)?.try_into().ok()?);
    bytes.drain(..HEAD);
    if head != checksum(&bytes) {
        return None;
    }
    if let Ok(file) = std::fs::File::options().append(true).open(path) {
        let _ = file.set_modified(SystemTime::now());
    }
    Some(bytes)
}

/// Other runs see all of it or nothing.
fn write(path: &Path, data: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let bytes = [&checksum(data).to_le_bytes(), data].concat();
    replace_file(path, &bytes).map_err(std::io::Error::other)
}

/// Removes the files used longest ago until the others take three quarters of `limit`, if all take more than it.
fn make_room(folder: &Path, limit: u64) -> std::io::Result<()> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)?.flatten() {
        let meta = entry.metadata()?;
        if meta.is_file() {
            files.push((meta.modified()?, meta.len(), entry.path()));
        }
    }
    let mut total: u64 = files.iter().map(|(_, len, _)| len).sum();
    if total <= limit {
        return Ok(());
    }
    files.sort();
    for (_, len, path) in files {
        if total <= limit / 4 * 3 {
            break;
        }
        std::fs::remove_file(path)?;
        total -= len;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_cut_off_is_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("deeper/x");
        assert_eq!(read(&path), None);
        write(&path, b"pipeline").expect("written");
        assert_eq!(read(&path).as_deref(), Some(&b"pipeline"[..]));
        let whole = std::fs::read(&path).expect("there");
        for len in 0..whole.len() {
            std::fs::write(&path, &whole[..len]).expect("written");
            assert_eq!(read(&path), None, "{len} bytes");
        }
    }

    #[test]
    fn the_files_used_longest_ago_make_room() {
        let folder = tempfile::tempdir().expect("a folder");
        for (k, name) in ["a", "b", "c", "d"].iter().enumerate() {
            let path = folder.path().join(name);
            write(&path, &[0; 92]).expect("written");
            let file = std::fs::File::options().append(true).open(&path).expect("there");
            file.set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(k as u64)).expect("dated");
        }
        read(&folder.path().join("a")).expect("used");
        let left = || ["a", "b", "c", "d"].map(|name| folder.path().join(name).exists());
        make_room(folder.path(), 400).expect("nothing to do");
        assert_eq!(left(), [true; 4]);
        make_room(folder.path(), 399).expect("room");
        assert_eq!(left(), [true, false, false, true]);
    }
}

//! Calls of Open Image Denoise 2 through its C interface. Source: its documentation, "Open Image Denoise API".
//!
//! One of the places with unsafe code: functions of a library that is loaded at run time. All of it is in [`Library`] and [`Filter`]; nothing of the
//! library outlives them, and memory that it writes to is owned by this module until it has returned.
#![allow(unsafe_code)]

use super::{DenoiseError, DenoiseQuality, DenoiseSettings, Plane, Prefilter};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// `OIDN_DEVICE_TYPE_CPU`.
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;
/// `OIDN_ERROR_CANCELLED`.
const CANCELLED: c_int = 6;
/// Oldest version whose functions have the names used here.
const OLDEST: c_int = 20_000;

type Handle = *mut c_void;
type Monitor = extern "C" fn(*mut c_void, f64) -> bool;

/// Functions of the library, by their names in C without the prefix.
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    set_device_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_image: unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    set_filter_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    set_monitor: unsafe extern "C" fn(Handle, Monitor, *mut c_void),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
}

/// The library and its functions.
pub(super) struct Library {
    calls: Functions,
    path: PathBuf,
    version: c_int,
    /// Last, so that it is unloaded after all else is gone.
    _loaded: libloading::Library,
}

impl Library {
    /// The first of the files that loads and is new enough.
    ///
    /// # Errors
    /// None loads: what is wrong with one that exists, else that there is none.
    pub fn load(files: &[PathBuf]) -> Result<Self, DenoiseError> {
        let mut first_wrong = None;
        for path in files {
            match Self::open(path) {
                Ok(library) => return Ok(library),
                Err(reason) if path.is_file() => {
                    first_wrong = first_wrong.or(Some(DenoiseError::Unusable { path: path.display().to_string(), reason }));
                }
                Err(_) => {}
            }
        }
        Err(first_wrong.unwrap_or(DenoiseError::Missing { looked: " (beside the program or in the system's folders)".into() }))
    }

    fn open(path: &Path) -> Result<Self, String> {
        let loaded = load_file(path).map_err(|e| said(&e))?;
        // SAFETY: each type is that of the function in the header of version 2 (oidn.h); the table is dropped with the library.
        let calls = unsafe {
            Functions {
                new_device: function(&loaded, "oidnNewDevice")?,
                set_device_int: function(&loaded, "oidnSetDeviceInt")?,
                set_device_bool: function(&loaded, "oidnSetDeviceBool")?,
                get_device_int: function(&loaded, "oidnGetDeviceInt")?,
                get_device_error: function(&loaded, "oidnGetDeviceError")?,
                commit_device: function(&loaded, "oidnCommitDevice")?,
                release_device: function(&loaded, "oidnReleaseDevice")?,
                new_filter: function(&loaded, "oidnNewFilter")?,
                set_image: function(&loaded, "oidnSetSharedFilterImage")?,
                set_filter_bool: function(&loaded, "oidnSetFilterBool")?,
                set_filter_int: function(&loaded, "oidnSetFilterInt")?,
                set_monitor: function(&loaded, "oidnSetFilterProgressMonitorFunction")?,
                commit_filter: function(&loaded, "oidnCommitFilter")?,
                execute_filter: function(&loaded, "oidnExecuteFilter")?,
                release_filter: function(&loaded, "oidnReleaseFilter")?,
            }
        };
        let mut library = Self { calls, path: path.to_owned(), version: 0, _loaded: loaded };
        let device = Device::new(&library, 0).map_err(|e| e.to_string())?;
        let version = device.version();
        drop(device);
        if version < OLDEST {
            return Err(format!("it is version {}; version 2 or newer is needed", dotted(version)));
        }
        library.version = version;
        Ok(library)
    }

    /// Version and place.
    pub fn name(&self) -> String {
        format!("{} from '{}'", dotted(self.version), self.path.display())
    }
}

/// 20303 → "2.3.3".
fn dotted(version: c_int) -> String {
    format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
}

/// An error of the system's loader with its cause.
fn said(e: &libloading::Error) -> String {
    std::error::Error::source(e).map_or_else(|| e.to_string(), |cause| format!("{e}: {cause}"))
}

fn load_file(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // The library's own libraries lie beside it; on Windows that has to be said.
    #[cfg(windows)]
    // SAFETY: as below.
    unsafe {
        use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
        let flags = if path.is_absolute() { LOAD_WITH_ALTERED_SEARCH_PATH } else { 0 };
        Library::load_with_flags(path, flags).map(Into::into)
    }
    #[cfg(not(windows))]
    // SAFETY: loading runs the initialisers of a file that the user or the system names as Open Image Denoise, as linking to it would.
    unsafe {
        libloading::Library::new(path)
    }
}

/// A function by its name in C.
///
/// # Safety
/// `T` is the type of that function.
unsafe fn function<T: Copy>(library: &libloading::Library, name: &str) -> Result<T, String> {
    // SAFETY: the caller says so.
    let symbol = unsafe { library.get::<T>(name.as_bytes()) };
    symbol.map(|s| *s).map_err(|_| format!("it has no function {name}; version 2 or newer is needed"))
}

/// The processor as the library sees it.
struct Device<'l> {
    library: &'l Library,
    handle: Handle,
}

impl<'l> Device<'l> {
    /// With so many threads; 0: the library's choice.
    fn new(library: &'l Library, threads: usize) -> Result<Self, DenoiseError> {
        let calls = &library.calls;
        // SAFETY: the handle is checked before use; strings end in 0.
        unsafe {
            let handle = (calls.new_device)(CPU);
            if handle.is_null() {
                return Err(DenoiseError::Failed("it has no device for the processor".into()));
            }
            let device = Self { library, handle };
            if let Ok(n) = c_int::try_from(threads)
                && n > 0
            {
                (calls.set_device_int)(handle, c"numThreads".as_ptr(), n);
            }
            // Threads of the renderer share the cores.
            (calls.set_device_bool)(handle, c"setAffinity".as_ptr(), false);
            (calls.commit_device)(handle);
            device.checked().map(|()| device)
        }
    }

    fn version(&self) -> c_int {
        // SAFETY: the handle is alive.
        unsafe { (self.library.calls.get_device_int)(self.handle, c"version".as_ptr()) }
    }

    /// The last error, if there was one since it was asked for.
    fn checked(&self) -> Result<(), DenoiseError> {
        let mut text: *const c_char = std::ptr::null();
        // SAFETY: the handle is alive; the text lives until the next call and is copied here.
        unsafe {
            match (self.library.calls.get_device_error)(self.handle, &raw mut text) {
                0 => Ok(()),
                CANCELLED => Err(DenoiseError::Interrupted),
                code if text.is_null() => Err(DenoiseError::Failed(format!("error {code}"))),
                _ => Err(DenoiseError::Failed(CStr::from_ptr(text).to_string_lossy().into_owned())),
            }
        }
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `new_device`, released once.
        unsafe { (self.library.calls.release_device)(self.handle) }
    }
}

/// What the library tells while it works.
struct Watch<'w> {
    on_progress: &'w (dyn Fn(f64) + Sync),
    cancel: &'w AtomicBool,
}

extern "C" fn watch(user: *mut c_void, share: f64) -> bool {
    // SAFETY: `user` is the `Watch` that `Filter::run` holds while the library works; the library calls this from one thread at a time.
    let watch = unsafe { &*user.cast::<Watch>() };
    (watch.on_progress)(share);
    !watch.cancel.load(Ordering::Relaxed)
}

/// Runs the filter "RT" over `inputs` (name and plane; all of one size); its output.
fn run(device: &Device, inputs: &[(&CStr, &Plane)], flags: &[&CStr], quality: c_int, watched: &Watch) -> Result<Plane, DenoiseError> {
    let calls = &device.library.calls;
    let (width, height) = (inputs[0].1.width, inputs[0].1.height);
    if inputs.iter().any(|(_, p)| (p.width, p.height) != (width, height) || p.values.len() != 3 * width * height) {
        return Err(DenoiseError::Failed("the guides are of another size than the picture".into()));
    }
    let mut out = Plane { width, height, values: vec![0.0; 3 * width * height] };
    // SAFETY: planes have `3 * width * height` floats (checked above) and outlive the filter, which is released before this returns; inputs are only read.
    unsafe {
        let filter = (calls.new_filter)(device.handle, c"RT".as_ptr());
        device.checked()?;
        let image = |name: &CStr, data: *mut c_void| (calls.set_image)(filter, name.as_ptr(), data, FLOAT3, width, height, 0, 0, 0);
        for (name, plane) in inputs {
            image(name, plane.values.as_ptr().cast_mut().cast());
        }
        image(c"output", out.values.as_mut_ptr().cast());
        for flag in flags {
            (calls.set_filter_bool)(filter, flag.as_ptr(), true);
        }
        (calls.set_filter_int)(filter, c"quality".as_ptr(), quality);
        (calls.set_monitor)(filter, watch, std::ptr::from_ref(watched).cast_mut().cast());
        (calls.commit_filter)(filter);
        (calls.execute_filter)(filter);
        let result = device.checked();
        (calls.release_filter)(filter);
        result?;
    }
    Ok(out)
}

/// `OIDN_QUALITY_…`.
fn quality(q: DenoiseQuality, version: c_int) -> c_int {
    match q {
        DenoiseQuality::High => 6,
        // "Fast" is there from 2.3 on, "balanced" from 2.0.
        DenoiseQuality::Fast if version >= 20_300 => 4,
        DenoiseQuality::Balanced | DenoiseQuality::Fast => 5,
    }
}

/// Denoises `color`, its guides first where the settings say so.
pub(super) fn denoise(
    library: &Library,
    color: Plane,
    albedo: Option<Plane>,
    normal: Option<Plane>,
    settings: &DenoiseSettings,
    threads: usize,
    on_progress: &(dyn Fn(f64) + Sync),
    cancel: &AtomicBool,
) -> Result<Plane, DenoiseError> {
    let device = Device::new(library, threads)?;
    let quality = quality(settings.quality, library.version);
    let prefilters = settings.prefilter == Prefilter::Accurate;
    let n_steps = 1.0 + if prefilters { f64::from(u8::from(albedo.is_some()) + u8::from(normal.is_some())) } else { 0.0 };
    let n_done = AtomicU8::new(0);
    let told = |share: f64| on_progress((f64::from(n_done.load(Ordering::Relaxed)) + share) / n_steps);
    let watched = Watch { on_progress: &told, cancel };
    let prepared = |name: &CStr, plane: Option<Plane>| -> Result<Option<Plane>, DenoiseError> {
        match plane {
            Some(plane) if prefilters => {
                let out = run(&device, &[(name, &plane)], &[], quality, &watched)?;
                n_done.fetch_add(1, Ordering::Relaxed);
                Ok(Some(out))
            }
            other => Ok(other),
        }
    };
    let albedo = prepared(c"albedo", albedo)?;
    let normal = prepared(c"normal", normal)?;
    let mut inputs = vec![(c"color", &color)];
    if let Some(a) = &albedo {
        inputs.push((c"albedo", a));
        if let Some(n) = &normal {
            inputs.push((c"normal", n));
        }
    }
    let mut flags = vec![c"hdr"];
    if albedo.is_some() && settings.prefilter != Prefilter::Fast {
        flags.push(c"cleanAux");
    }
    run(&device, &inputs, &flags, quality, &watched)
}

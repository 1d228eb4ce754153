//! As much of Embree's C interface as the benchmark needs, opened at run time. Versions 3 and 4 differ in how a query's settings are passed.
//!
//! Layouts and numbers are those of `rtcore_ray.h`, `rtcore_common.h`, `rtcore_geometry.h` and `rtcore_buffer.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr;

use iorect::geometry::{self, Mesh, NO_PRIMITIVE};
use libloading::Library;

/// `RTC_GEOMETRY_TYPE_TRIANGLE`
const TRIANGLES: c_int = 0;
/// `RTC_BUFFER_TYPE_INDEX`
const INDEX: c_int = 0;
/// `RTC_BUFFER_TYPE_VERTEX`
const VERTEX: c_int = 1;
/// `RTC_FORMAT_UINT3`
const UINT3: c_int = 0x5003;
/// `RTC_FORMAT_FLOAT3`
const FLOAT3: c_int = 0x9003;
/// `RTC_DEVICE_PROPERTY_VERSION`
const VERSION: c_int = 0;
/// `RTC_INVALID_GEOMETRY_ID`
const INVALID: u32 = u32::MAX;

/// `RTCDevice`, `RTCScene`, `RTCGeometry`: pointers to what only Embree knows.
type Handle = *mut c_void;

/// `RTCRay`
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct Ray {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

impl Ray {
    /// The ray in f32. One that leaves a surface begins a little off it, as is usual with Embree.
    pub fn new(ray: &geometry::Ray, reach: f64) -> Self {
        Self {
            origin: ray.origin.as_vec3().to_array(),
            near: if ray.from == NO_PRIMITIVE { 0.0 } else { 1e-5 },
            direction: ray.direction.as_vec3().to_array(),
            time: 0.0,
            far: reach as f32,
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

/// `RTCRayHit`
#[repr(C, align(16))]
struct RayHit {
    ray: Ray,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    /// One in version 3; up to two in version 4. The rest is room for builds with more levels.
    instance: [u32; 16],
}

/// `RTCIntersectContext`, of version 3 only
#[repr(C)]
struct Context {
    flags: c_int,
    filter: *const c_void,
    instance: [u32; 8],
    /// In builds that scale curves by distance.
    min_width: f32,
}

impl Context {
    /// `rtcInitIntersectContext`: incoherent, no filter.
    const fn new() -> Self {
        Self { flags: 0, filter: ptr::null(), instance: [INVALID; 8], min_width: 0.0 }
    }
}

/// `rtcIntersect1`, `rtcOccluded1` of version 3: scene, context, ray or ray with hit.
type Query3 = unsafe extern "C" fn(Handle, *mut Context, *mut c_void);
/// The same of version 4: scene, ray or ray with hit, arguments (none: the defaults).
type Query4 = unsafe extern "C" fn(Handle, *mut c_void, *const c_void);

#[derive(Clone, Copy)]
enum Queries {
    Three { intersect: Query3, occluded: Query3 },
    Four { intersect: Query4, occluded: Query4 },
}

/// The library and a device.
pub struct Embree {
    library: Library,
    device: Handle,
    queries: Queries,
}

/// A scene of one mesh. It lives as long as the program: nothing here is released.
pub struct Scene {
    scene: Handle,
    queries: Queries,
}

impl Embree {
    /// Opens the first library found, version 4 before 3.
    ///
    /// # Errors
    /// When there is none, or it lacks a function.
    pub fn open() -> Result<Self, libloading::Error> {
        let open = |major: u32| {
            let names = [
                format!("libembree{major}.so.{major}"),
                format!("libembree{major}.so"),
                format!("libembree{major}.dylib"),
                format!("embree{major}.dll"),
            ];
            // SAFETY: loading Embree runs nothing but its own initialisers.
            names.into_iter().find_map(|name| unsafe { Library::new(name) }.ok()).map(|library| (major, library))
        };
        let (major, library) = match open(4).or_else(|| open(3)) {
            Some(found) => found,
            // SAFETY: as above; this fails and says why.
            None => (3, unsafe { Library::new("libembree3.so") }?),
        };
        // SAFETY: the signatures are those of the headers of that version.
        unsafe {
            let device = library.get::<unsafe extern "C" fn(*const c_char) -> Handle>(b"rtcNewDevice\0")?(ptr::null());
            let queries = if major == 3 {
                Queries::Three {
                    intersect: *library.get(b"rtcIntersect1\0")?,
                    occluded: *library.get(b"rtcOccluded1\0")?,
                }
            } else {
                Queries::Four {
                    intersect: *library.get(b"rtcIntersect1\0")?,
                    occluded: *library.get(b"rtcOccluded1\0")?,
                }
            };
            Ok(Self { library, device, queries })
        }
    }

    /// Like 3.13.5.
    pub fn version(&self) -> String {
        let number = self.call(b"rtcGetDeviceProperty\0", |get: unsafe extern "C" fn(Handle, c_int) -> isize| {
            // SAFETY: the device is valid, the property exists in both versions.
            unsafe { get(self.device, VERSION) }
        });
        format!("{}.{}.{}", number / 10_000, number / 100 % 100, number % 100)
    }

    /// Builds a scene of medium quality, on all cores.
    pub fn build(&self, mesh: &Mesh) -> Scene {
        type NewGeometry = unsafe extern "C" fn(Handle, c_int) -> Handle;
        type NewBuffer = unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
        type New = unsafe extern "C" fn(Handle) -> Handle;
        type Commit = unsafe extern "C" fn(Handle);
        type Attach = unsafe extern "C" fn(Handle, Handle) -> c_uint;
        // SAFETY: the signatures are the headers'; Embree allocates each buffer as long as it was asked for, and padded.
        unsafe {
            let geometry = self.call(b"rtcNewGeometry\0", |new: NewGeometry| new(self.device, TRIANGLES));
            let buffer = |kind, format, count| {
                self.call(b"rtcSetNewGeometryBuffer\0", |new: NewBuffer| new(geometry, kind, 0, format, 12, count))
            };
            let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect();
            let vertices = buffer(VERTEX, FLOAT3, positions.len()).cast::<[f32; 3]>();
            ptr::copy_nonoverlapping(positions.as_ptr(), vertices, positions.len());
            let triangles = buffer(INDEX, UINT3, mesh.triangles.len()).cast::<[u32; 3]>();
            ptr::copy_nonoverlapping(mesh.triangles.as_ptr(), triangles, mesh.triangles.len());
            self.call(b"rtcCommitGeometry\0", |commit: Commit| commit(geometry));
            let scene = self.call(b"rtcNewScene\0", |new: New| new(self.device));
            self.call(b"rtcAttachGeometry\0", |attach: Attach| attach(scene, geometry));
            self.call(b"rtcCommitScene\0", |commit: Commit| commit(scene));
            Scene { scene, queries: self.queries }
        }
    }

    /// Hands the function called `name` to `work`.
    fn call<F: Copy, R>(&self, name: &[u8], work: impl FnOnce(F) -> R) -> R {
        // SAFETY: the callers name the type that the headers give.
        match unsafe { self.library.get::<F>(name) } {
            Ok(function) => work(*function),
            Err(error) => panic!("Embree lacks a function: {error}"),
        }
    }
}

impl Scene {
    /// The first triangle hit, however far; `u32::MAX` for none.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> u32 {
        let mut hit = RayHit {
            ray: Ray { far: f32::INFINITY, ..*ray },
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: INVALID,
            geometry: INVALID,
            instance: [INVALID; 16],
        };
        let pointer = ptr::from_mut(&mut hit).cast();
        // SAFETY: the scene is committed; the structures are laid out as the headers say.
        unsafe {
            match self.queries {
                Queries::Three { intersect, .. } => intersect(self.scene, &mut Context::new(), pointer),
                Queries::Four { intersect, .. } => intersect(self.scene, pointer, ptr::null()),
            }
        }
        hit.primitive
    }

    /// Whether anything is hit within its reach. Embree says so by a far end of −∞.
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        let mut ray = *ray;
        let pointer = ptr::from_mut(&mut ray).cast();
        // SAFETY: as above.
        unsafe {
            match self.queries {
                Queries::Three { occluded, .. } => occluded(self.scene, &mut Context::new(), pointer),
                Queries::Four { occluded, .. } => occluded(self.scene, pointer, ptr::null()),
            }
        }
        ray.far < 0.0
    }
}

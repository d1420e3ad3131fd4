// The same library from Rust, without a crate: rustc feel.rs -L /usr/lib/… -l palpa
use std::ffi::{c_char, c_void, CStr};

#[repr(C)]
struct Probe {
    size: u32,
    buttons: u32,
    valid: i32,
    has_velocity: i32,
    position_m: [f64; 3],
    velocity_m_per_s: [f64; 3],
    turn: [f64; 4],
}

#[repr(C)]
struct Tick {
    size: u32,
    status: i32,
    force_n: [f64; 3],
    proxy_m: [f64; 3],
    rest: [f64; 43], // the other fields of palpa_tick
}

extern "C" {
    fn palpa_last_error() -> *const c_char;
    fn palpa_scene_parse(toml: *const c_char, folder: *const c_char) -> *mut c_void;
    fn palpa_scene_free(scene: *mut c_void);
    fn palpa_session_new(scene: *const c_void, encoder_step_m: f64) -> *mut c_void;
    fn palpa_session_free(session: *mut c_void);
    fn palpa_session_tick(session: *mut c_void, probe: *const Probe, time_step_s: f64, out: *mut Tick) -> i32;
}

const TOML: &[u8] = b"palpa = 1
coupling = {stiffness_n_per_m = 400}
volume.head = {analytic = \"head_phantom\"}
[[mode]]
name = \"skin\"
type = \"surface_and_friction\"
field = \"head\"
level = [{name = \"skin\", value = -300, strength_n = 0.8, friction_n = 0.1}]
\0";

fn last_error() -> String {
    unsafe { CStr::from_ptr(palpa_last_error()).to_string_lossy().into_owned() }
}

fn main() {
    let session = unsafe {
        let scene = palpa_scene_parse(TOML.as_ptr().cast(), std::ptr::null());
        assert!(!scene.is_null(), "{}", last_error());
        let session = palpa_session_new(scene, 0.0);
        palpa_scene_free(scene);
        session
    };
    assert!(!session.is_null(), "{}", last_error());
    let mut tick: Tick = unsafe { std::mem::zeroed() };
    tick.size = std::mem::size_of::<Tick>() as u32;
    for n in 0..41 {
        let hand = Probe {
            size: std::mem::size_of::<Probe>() as u32,
            buttons: 0,
            valid: 1,
            has_velocity: 0,
            position_m: [0.0, 0.02, 0.05 - 1e-4 * f64::from(n)],
            velocity_m_per_s: [0.0; 3],
            turn: [1.0, 0.0, 0.0, 0.0],
        };
        let result = unsafe { palpa_session_tick(session, &hand, 1e-3, &mut tick) };
        assert_eq!(result, 0, "{}", last_error());
    }
    unsafe { palpa_session_free(session) };
    let force_n = tick.force_n.iter().map(|f| f * f).sum::<f64>().sqrt();
    println!("force {force_n:.3} N");
    assert!(force_n > 0.1);
}

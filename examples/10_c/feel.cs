// The same library from C#, as in a plug-in of Unity: mcs feel.cs && mono feel.exe
using System;
using System.Runtime.InteropServices;

[StructLayout(LayoutKind.Sequential)]
struct Vector { public double x, y, z; }

[StructLayout(LayoutKind.Sequential)]
struct Turn { public double w, x, y, z; }

[StructLayout(LayoutKind.Sequential)]
struct Probe {
  public uint size, buttons;
  public int valid, has_velocity;
  public Vector position_m, velocity_m_per_s;
  public Turn turn;
}

[StructLayout(LayoutKind.Sequential, Size = 400)]  // palpa_tick; its other fields follow
struct Tick {
  public uint size;
  public int status;
  public Vector force_n, proxy_m;
}

static class Palpa {
  const string library = "libpalpa.so.0.1";
  [DllImport(library)] static extern IntPtr palpa_last_error();
  [DllImport(library)] public static extern IntPtr palpa_scene_parse(string toml, string folder);
  [DllImport(library)] public static extern void palpa_scene_free(IntPtr scene);
  [DllImport(library)] public static extern IntPtr palpa_session_new(IntPtr scene, double encoder_step_m);
  [DllImport(library)] public static extern void palpa_session_free(IntPtr session);
  [DllImport(library)] public static extern int palpa_session_tick(IntPtr session, ref Probe hand, double time_step_s, ref Tick tick);
  public static string LastError() { return Marshal.PtrToStringAnsi(palpa_last_error()); }  // UTF-8 on Linux
}

static class Feel {
  const string toml = @"palpa = 1
coupling = {stiffness_n_per_m = 400}
volume.head = {analytic = ""head_phantom""}
[[mode]]
name = ""skin""
type = ""surface_and_friction""
field = ""head""
level = [{name = ""skin"", value = -300, strength_n = 0.8, friction_n = 0.1}]
";

  static int Main() {
    IntPtr scene = Palpa.palpa_scene_parse(toml, null);
    IntPtr session = scene == IntPtr.Zero ? IntPtr.Zero : Palpa.palpa_session_new(scene, 0);
    if (session == IntPtr.Zero) { Console.Error.WriteLine(Palpa.LastError()); return 1; }
    Palpa.palpa_scene_free(scene);
    var hand = new Probe { size = (uint)Marshal.SizeOf(typeof(Probe)), valid = 1, turn = new Turn { w = 1 } };
    var tick = new Tick { size = (uint)Marshal.SizeOf(typeof(Tick)) };
    for (int n = 0; n < 41; ++n) {  // a hand presses, 1 ms a tick
      hand.position_m = new Vector { x = 0, y = 0.02, z = 0.05 - 1e-4 * n };
      if (Palpa.palpa_session_tick(session, ref hand, 1e-3, ref tick) != 0) { Console.Error.WriteLine(Palpa.LastError()); return 1; }
    }
    Palpa.palpa_session_free(session);
    Vector f = tick.force_n;
    double force_n = Math.Sqrt(f.x * f.x + f.y * f.y + f.z * f.z);
    Console.WriteLine(string.Format(System.Globalization.CultureInfo.InvariantCulture, "force {0:F3} N", force_n));
    return force_n > 0.1 ? 0 : 1;
  }
}

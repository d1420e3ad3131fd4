/* Palpa for C and for every language that can call C: scenes, sessions, both sides of a hand far from its data, and a device.
 * docs/c.md begins with a first force.
 *
 * C99; also C++. Distances in metres, forces in newtons, times in seconds, in the hand's frame unless said otherwise.
 *
 * Failures: NULL, or a negative result; palpa_last_error() then has the sentence. NULL, a wrong size, a number that is not
 * finite and calls in a wrong order are failures, never a crash. No exception leaves a function, none calls back; a recording
 * alone has a thread that outlives a call, until its end.
 *
 * Structs begin with `size`: set it to sizeof the struct before each call. New fields are added at the end alone, so that a
 * program built with an older header, whose size is smaller, works with a newer library; fields that it lacks have their
 * default. A size that is smaller than that of the first header, or larger than this library's, is a failure.
 *
 * Threads: a handle is for one thread at a time; different handles are independent. Functions allocate unless it is said that
 * they do not. */
#ifndef PALPA_C_H
#define PALPA_C_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Library: in libpalpa-hand, too ---- */

/* Number of this header's interface. It grows by one with every addition; palpa_abi() of a library is at least the number that
 * the program was built with, or the library is too old for it. */
#define PALPA_ABI 3

/* Result: 0, or a negative number for the kind of a failure. Each further negative number is a failure, too. */
typedef int32_t palpa_result;
enum {
  PALPA_OK = 0,
  PALPA_WRONG_ARGUMENT = -1, /* NULL, a wrong size, a value out of its range, a call in a wrong order */
  PALPA_WRONG_DATA = -2,     /* a scene or voxels that cannot be used */
  PALPA_NO_MEMORY = -3,
  PALPA_FAULT = -4 /* any other; a fault of Palpa */
};

/* Interface number of this library. Any thread; does not allocate. */
uint32_t palpa_abi(void);

/* Version of this library, such as "0.1.0". Static. Any thread; does not allocate. */
const char* palpa_version(void);

/* Last failure of the calling thread, in one line: `PLACE: what is wrong; what would be right`. UTF-8. "" before the first
 * failure; a success leaves it unchanged. Valid until the thread's next failure. Does not allocate. */
const char* palpa_last_error(void);

/* Frees a text that a function returned with ownership. NULL: nothing. Any thread. */
void palpa_free(void* text);

/* ---- Scene: volumes, modes, coupling ---- */

typedef struct palpa_scene palpa_scene;

/* Types of voxels. */
enum { PALPA_UINT8 = 0, PALPA_INT16 = 1, PALPA_UINT16 = 2, PALPA_INT32 = 3, PALPA_FLOAT32 = 4, PALPA_FLOAT64 = 5 };

/* Voxels on an affine grid. Voxel (i, j, k) is at origin_m + i axes_m[0] + j axes_m[1] + k axes_m[2]; i is fastest in memory,
 * the components of a voxel are together. Its value is raw * slope + intercept. */
typedef struct palpa_grid {
  uint32_t size;
  int32_t type;          /* PALPA_UINT8 … PALPA_FLOAT64 */
  int32_t components;    /* [1] 1: scalar; 3: vector, along the world's x, y, z */
  int32_t medical_frame; /* 1: x to the patient's left, y to the back, z to the head; 0: no patient */
  int64_t dims[3];       /* [1] voxels along i, j, k; at least 1 each */
  double origin_m[3];    /* [m, world] centre of voxel (0, 0, 0) */
  double axes_m[3][3];   /* [m, world] step of one index along i, j, k; linearly independent */
  const void* voxels;    /* dims[0] * dims[1] * dims[2] * components numbers of the type */
  size_t bytes;          /* [bytes] at `voxels`: exactly as many as these numbers have */
  double slope;          /* [the field's own unit] per raw step; finite, not 0; 1: the numbers themselves */
  double intercept;      /* [the field's own unit] finite */
} palpa_grid;

/* Reads a scene file (docs/scene.md) and the volumes that it names; files are opened by the program palpa-read
 * (docs/embedding.md). A table [volume.NAME] with neither 'file' nor 'analytic' is the place of a grid that
 * palpa_scene_add_grid gives: until then no session can begin.
 * path: UTF-8. Returns a scene, to be freed by palpa_scene_free; NULL: failure, with file, line and column. */
palpa_scene* palpa_scene_load(const char* path);

/* Likewise from a text.
 * toml: UTF-8, copied. folder: of the files that the text names relatively; NULL: the current folder. */
palpa_scene* palpa_scene_parse(const char* toml, const char* folder);

/* Returns an independent copy, to be freed; voxels are shared. NULL: failure. */
palpa_scene* palpa_scene_copy(const palpa_scene* scene);

/* Frees a scene; its sessions keep what they need. NULL: nothing. */
void palpa_scene_free(palpa_scene* scene);

/* Gives the data of [volume.NAME], a table with neither 'file' nor 'analytic', or replaces a grid given earlier; its keys, such
 * as 'pose' and 'filter', hold. The field is NAME. Copies the voxels. A failure leaves the scene unchanged.
 * name: of a volume of the scene. grid: not kept. */
palpa_result palpa_scene_add_grid(palpa_scene* scene, const char* name, const palpa_grid* grid);

/* Sets one value, as --set PATH=VALUE of the program palpa: path "coupling.max_force_n", value "2". Files are not read again.
 * Sessions are of the scene as it was; a new one with palpa_session_take_over feels the change. A failure leaves the scene
 * unchanged. */
palpa_result palpa_scene_set(palpa_scene* scene, const char* path, const char* value);

/* The scene as TOML, with all that was set; read with the same folder and given the same grids it feels equal. Returns UTF-8,
 * to be freed by palpa_free; NULL: failure, as for a scene whose grids are not all given. */
char* palpa_scene_text(const palpa_scene* scene);

/* Warnings about the scene, a line each, such as a level outside of the data's range; a scene whose grids are not all given has
 * a line that names the first of these. Returns UTF-8, to be freed by palpa_free, "" for none; NULL: failure. */
char* palpa_scene_warnings(const palpa_scene* scene);

/* ---- Files that the program reads itself ---- */

/* Where palpa-read is not there, as in a browser, or where a program has data of its own: a scene's text that says
 * file = "NAME" takes what was added as NAME, and opens nothing. A trace of it is felt again by palpa replay with the file. */
typedef struct palpa_files palpa_files;

/* An array of a file. */
typedef struct palpa_file_field {
  const char* name; /* of the array; UTF-8 */
  const char* unit; /* of its values, such as "HU"; NULL: unknown */
  const palpa_grid* grid;
} palpa_file_field;

/* A file on disk that a content was read from. */
typedef struct palpa_file_source {
  const char* name;   /* as a scene names it; UTF-8 */
  const char* sha256; /* hexadecimal; NULL: unknown, a trace is then not felt again */
  uint64_t bytes;
} palpa_file_source;

/* A file's content. */
typedef struct palpa_file {
  uint32_t size;
  int32_t length_unit_assumed;    /* 1: neither file nor person said it; else 0 */
  const char* format;             /* "nrrd", "nifti", "meta", "dicom", … */
  const char* modality;           /* "CT", "MR", …; NULL: unknown */
  const char* length_unit;        /* of the file, such as "mm"; the grids are in metres */
  const palpa_file_field* fields; /* at least one */
  size_t field_count;
  const palpa_file_source* sources; /* all its files on disk, for traces; NULL with 0: none */
  size_t source_count;
} palpa_file;

/* Begins a set without files. Returns what palpa_files_free frees; NULL: failure. */
palpa_files* palpa_files_new(void);

/* Frees it; scenes that were parsed with it keep what they need. NULL: nothing. */
void palpa_files_free(palpa_files* files);

/* Adds a file, or replaces it. Copies everything. name: as scenes name it; UTF-8. A failure changes nothing. */
palpa_result palpa_files_add(palpa_files* files, const char* name, const palpa_file* file);

/* Facts of a file, as palpa info --json prints them, as far as the grids have them: JSON with "grid" and "fields". Reads all
 * voxels. Returns UTF-8, to be freed by palpa_free; NULL: failure. */
char* palpa_files_facts(const palpa_files* files, const char* name);

/* First scene of a file, as palpa info --scene writes it. Reads all voxels a few times. Returns TOML, to be freed by
 * palpa_free; NULL: failure, as where there is nothing to feel. */
char* palpa_files_first_scene(const palpa_files* files, const char* name);

/* As palpa_scene_parse, with these files before those of folders. files: the scene has those of now. */
palpa_scene* palpa_scene_parse_with(const char* toml, const palpa_files* files);

/* ---- Scene for a picture ---- */

/* The scene in numbers, for programs that show it: JSON with "title", "fields" (name, unit, components, range, histogram),
 * "modes" (name, type, field, enabled, strength_n, levels with the path that palpa_scene_set takes), "layers", "hand_to_world"
 * (16 numbers by row), "bounds_m", "stiffness_n_per_m" and "max_force_n". Reads voxels. Returns UTF-8, to be freed by
 * palpa_free; NULL: failure. */
char* palpa_scene_facts(const palpa_scene* scene);

/* Samples a field on a lattice: point (i, j, k) is at origin_m + i axes_m[0] + j axes_m[1] + k axes_m[2] of `lattice`, whose
 * voxels are not used.
 * field: "volume.field", or the volume's name alone. out: dims[0] * dims[1] * dims[2] values, i fastest, of a vector field x, y
 * and z of each point; NaN where there are no data. count: [1] of numbers in `out`, exactly as many. */
palpa_result palpa_scene_sample(const palpa_scene* scene, const char* field, const palpa_grid* lattice, float* out,
                                size_t count);

/* ---- Session: a scene in use ---- */

typedef struct palpa_session palpa_session;

/* The hand's point as reported by the device. */
typedef struct palpa_probe {
  uint32_t size;
  uint32_t buttons;           /* bits */
  int32_t valid;              /* 0: the device has no position; else it has one */
  int32_t has_velocity;       /* 0: the velocity is derived from the positions */
  double position_m[3];       /* each within 1000 */
  double velocity_m_per_s[3]; /* finite; unused where has_velocity is 0 */
  double turn[4]; /* [1] orientation of the handle: w, x, y, z of a unit quaternion to within 1e-3; unused by a point tool */
} palpa_probe;

/* Status of a tick. */
enum {
  PALPA_COMPLETE = 0, /* the proxy is at the balance for this probe position */
  PALPA_WAITING = 1,  /* work budget exhausted: rest of the probe's path queued, no force from it */
  PALPA_CAPPED = 2,   /* complete, but a balance's error bound is above 1e-9 m */
  PALPA_BAD_INPUT = 3 /* unusable probe or time step: the proxy stayed, the force is zero */
};

/* Result of one tick. force_n is the coupling's force before any guard: docs/safety.md. */
typedef struct palpa_tick {
  uint32_t size;
  int32_t status;    /* PALPA_COMPLETE … PALPA_BAD_INPUT */
  double force_n[3]; /* on the hand */
  double proxy_m[3];
  double proxy_velocity_m_per_s[3];
  double probe_m[3];                /* as given, finite or not */
  double probe_velocity_m_per_s[3]; /* likewise, or of the last step */
  double probe_step_m[3];           /* since the last tick, while its force acted; zero after a reset */
  double error_bound_m;             /* proven; the largest of the sub-steps */
  double given_back_n;              /* part of the force that was withheld in incomplete ticks and returned in this one */
  double unborne_n;                 /* part of the spring's force that the primitives do not balance */
  double felt_octave;               /* [1] 0: the finest */
  int32_t probe_valid;              /* 0 or 1 */
  int32_t forced_octave;            /* 0 or 1 */
  int32_t sub_steps;                /* [1] */
  int32_t iterations;               /* [1] of all sub-steps */
  int32_t dropped;                  /* [1] primitives refused */
  int32_t work;                     /* [1] units, counted alike on every machine */
  double stored_j;                  /* in the spring after the tick */
  double elastic_j;                 /* in elastic levels after the tick */
  double dissipated_j;              /* by modes */
  double injected_j;                /* by modes */
  double path_and_release_j;        /* error of the path's sub-steps */
  double damper_j;                  /* work of the damper on the hand */
  double data_motion_j;             /* work of the data's motion */
  double released_j;                /* released by the springs */
  double sampling_j;                /* sampling error */
  double sampling_bound_j;          /* upper bound of that of a single balance */
  double torque_nm[3];              /* about the device's point, before any guard; of a tool with an orientation, else zero */
  double probe_turn[4];             /* [1] w, x, y, z; of a tool with an orientation, as given; else no rotation */
  double proxy_turn[4];             /* [1] likewise */
  double probe_turn_step_rad[3];    /* rotation vector of the probe since the last tick */
} palpa_tick;

/* Kinds of events. */
enum { PALPA_ONSET = 0, PALPA_BREAK_THROUGH = 1, PALPA_EVENT_FAULT = 2, PALPA_EVENT_WARNING = 3 };

/* Event of a tick. */
typedef struct palpa_event {
  uint32_t size;
  int32_t kind;   /* PALPA_ONSET … PALPA_EVENT_WARNING */
  int32_t mode;   /* [1] the mode's number, from 0 in the scene's order; -1: the session */
  int32_t unused; /* 0 */
  double value;   /* of onset and break-through: the level, in the field's own unit */
  double depth_m; /* of break-through: |proxy - probe| where the strength was reached */
  char text[120]; /* of fault and warning: the cause, UTF-8, shortened to fit; else "" */
} palpa_event;

/* Begins a session of the scene as it is now, whose voxels it shares.
 * encoder_step_m: position step of the device, finite, at least 0; 0: none. Returns a session, to be freed by
 * palpa_session_free; NULL: failure, as for a volume larger than memory, whose windows a tick of C cannot read. */
palpa_session* palpa_session_new(const palpa_scene* scene, double encoder_step_m);

/* Frees a session. NULL: nothing. */
void palpa_session_free(palpa_session* session);

/* One tick: the proxy moves to the balance, the coupling pulls the hand. UNGUARDED: never send its force to motors without the
 * limits of docs/safety.md. Neither allocates nor locks but, after a failure, for the thread's sentence; bounded work
 * (docs/path.md).
 * time_step_s: since the last tick, above 0, at most 1. out: filled in for every result but a wrong session, size or pointer,
 * with finite forces; not kept.
 * Returns PALPA_WRONG_ARGUMENT for a probe or a time step that cannot be used: the tick took place with PALPA_BAD_INPUT, its
 * force is zero, and the session begins anew at the next usable probe. An invalid probe is no failure. */
palpa_result palpa_session_tick(palpa_session* session, const palpa_probe* probe, double time_step_s, palpa_tick* out);

/* Continues from the other session, of a changed scene: with its whole state if the modes of both use equal levels of equal
 * data, as after a change of strengths or coupling; else with its proxy and time, and fresh memories. Does not allocate. */
palpa_result palpa_session_take_over(palpa_session* session, const palpa_session* other);

/* Puts the proxy on the next probe position and resets all memories: after a gap or a clutch. NULL: nothing. Does not
 * allocate. */
void palpa_session_reset(palpa_session* session);

/* Events of the last tick. Neither allocates nor locks.
 * out: array of `room` events, or NULL to count; out[0].size is the size of each. Returns the number of events, of which the
 * first `room` are in `out`; 0 with a new palpa_last_error() for a NULL session or a wrong size. */
size_t palpa_session_events(const palpa_session* session, palpa_event* out, size_t room);

/* ---- Data: the data's side of a hand that is far ---- */

/* Messages between the two sides (docs/far.md) are bytes, carried by the program, whole, each on its own: by WebSocket,
 * datagrams or memory. They are refused if damaged, and never believed: a hostile peer can make forces wrong, not unlimited. */
enum { PALPA_MESSAGE_BYTES = 4096 /* [bytes] the longest */ };

/* Times: the data's side has the clock of its machine, a hand that of its ticks' time steps, which are real time for a hand
 * that is felt. A simulation that runs faster or slower than real time gets models for another link than its own. */
typedef struct palpa_data palpa_data;

/* Begins the data's side of one hand, of the scene as it is now, whose voxels it shares. Returns what palpa_data_free frees;
 * NULL: failure, as for a scene with a tool that turns. */
palpa_data* palpa_data_new(const palpa_scene* scene);

/* Frees it. NULL: nothing. */
void palpa_data_free(palpa_data* data);

/* Takes a message of the hand: its first begins a session within the limits of its device, each later one ticks that. May read
 * windows of a volume larger than memory: not for a real-time thread.
 * Returns PALPA_WRONG_DATA for a message that is none, is damaged, was overtaken by a later one or comes in a wrong order: it
 * is passed over. */
palpa_result palpa_data_take(palpa_data* data, const void* message, size_t bytes);

/* Writes the next message for the hand; to be called until 0, after each palpa_data_take and every few milliseconds.
 * room: [bytes] at `message`, at least PALPA_MESSAGE_BYTES. Returns its length [bytes]; 0: none, or with a new
 * palpa_last_error() for a wrong argument. */
size_t palpa_data_give(palpa_data* data, void* message, size_t room);

/* Replaces the scene; the hand feels the change spread over the guard's ramp, and continues where it is. A failure changes
 * nothing. */
palpa_result palpa_data_change(palpa_data* data, const palpa_scene* scene);

/* ---- Hand: the side that holds the device; in libpalpa-hand, too ---- */

typedef struct palpa_hand palpa_hand;

/* Limits of a device. All zero but `size`: no force. */
typedef struct palpa_limits {
  uint32_t size;
  int32_t has_motors;           /* 1: a person holds them: the whole guard; 0: a simulated hand: the force limit alone */
  uint32_t dead_man_buttons;    /* bits: a force needs one of these; 0: none */
  int32_t unused;               /* 0 */
  double max_force_n;           /* at least 0, finite */
  double max_stiffness_n_per_m; /* at least 0; infinity: no limit */
  double max_damping_ns_per_m;  /* at least 0; infinity: no limit */
  double continuous_force_n;    /* that the motors can hold permanently, at least 0; infinity: no limit */
  double encoder_step_m;        /* at least 0, finite; 0: none */
  double damping_ns_per_m;      /* of the device's own mechanics, at least 0, finite */
  uint8_t token[16];            /* right to touch, of a data's side that asks for one; else zero */
} palpa_limits;

/* Effect of the guard on the force (docs/safety.md). */
enum {
  PALPA_GUARD_PASS = 0,    /* unchanged */
  PALPA_GUARD_LIMITED = 1, /* shortened, or limited in growth or rotation */
  PALPA_GUARD_FAULT = 2,   /* not finite: zero */
  PALPA_GUARD_WAITING = 3, /* zero until the force would be small */
  PALPA_GUARD_RAMP = 4,    /* a growing share */
  PALPA_GUARD_DAMPED = 5,  /* with damping, by energy output beyond input */
  PALPA_GUARD_FALLING = 6, /* the last command decreases to zero */
  PALPA_GUARD_OFF = 7      /* zero until a person resumes */
};

/* Causes of a reduced or zero force. */
enum {
  PALPA_CAUSE_NONE = 0,
  PALPA_CAUSE_START = 1, /* session start, or resumed by a person */
  PALPA_CAUSE_NOT_FINITE = 2,
  PALPA_CAUSE_NO_POSITION = 3,
  PALPA_CAUSE_DEVICE_FAULT = 4,
  PALPA_CAUSE_LINK_LOST = 5, /* to the device */
  PALPA_CAUSE_LATE = 6,
  PALPA_CAUSE_SPEED = 7, /* the hand is too fast */
  PALPA_CAUSE_VIEW_MOVES = 8,
  PALPA_CAUSE_DEAD_MAN = 9,
  PALPA_CAUSE_PANIC = 10,
  PALPA_CAUSE_STOPS = 11,
  PALPA_CAUSE_OTHER_HAND = 12,
  PALPA_CAUSE_LINK_STALE = 13, /* the model is older than usual by 100 ms */
  PALPA_CAUSE_LINK_CLOSED = 14 /* no connection to the data, or a model of an unknown scene */
};

/* Link between the hand and its data. */
enum {
  PALPA_LINK_WAITING = 0, /* no model yet */
  PALPA_LINK_UP = 1,
  PALPA_LINK_STALE = 2,
  PALPA_LINK_CLOSED = 3
};

/* Command of one tick of a hand. */
typedef struct palpa_command {
  uint32_t size;
  int32_t guard;        /* PALPA_GUARD_PASS … PALPA_GUARD_OFF */
  int32_t cause;        /* PALPA_CAUSE_NONE … PALPA_CAUSE_LINK_CLOSED */
  int32_t link;         /* PALPA_LINK_WAITING … PALPA_LINK_CLOSED */
  int32_t brakes;       /* 1: the device's brake should hold the hand; else 0 */
  int32_t beyond;       /* 1: the proxy is further off than the model is valid; else 0 */
  double force_n[3];    /* for the motors: within the limits */
  double coupling_n[3]; /* of the coupling, before the guard */
  double proxy_m[3];
  double model_age_s;  /* since the probe that the model answers */
  double round_trip_s; /* of the link, mean of the last second */
} palpa_command;

/* Begins the hand's side. limits: of the device, not kept. Returns a hand, to be freed by palpa_hand_free; NULL: failure. */
palpa_hand* palpa_hand_new(const palpa_limits* limits);

/* Frees a hand. NULL: nothing. */
void palpa_hand_free(palpa_hand* hand);

/* Takes a message of the data's side. Neither allocates nor locks.
 * message: NULL with bytes 0: the connection was closed; after one tick without a force the hand begins a new one, with another
 * data's side. Returns PALPA_WRONG_DATA for a message that is none, is damaged, or is older than one taken before: it is passed
 * over. */
palpa_result palpa_hand_take(palpa_hand* hand, const void* message, size_t bytes);

/* Writes the next message for the data's side; to be called until 0, after each tick. Neither allocates nor locks.
 * room: [bytes] at `message`, at least PALPA_MESSAGE_BYTES. Returns its length [bytes]; 0: none, or with a new
 * palpa_last_error() for a wrong argument. */
size_t palpa_hand_give(palpa_hand* hand, void* message, size_t room);

/* One tick, at 1 to 4 kHz: the newest model at this probe position. Orientation and velocity of the probe are not used. Neither
 * allocates nor locks but, after a failure, for the thread's sentence.
 * time_step_s: real time since the last tick, above 0, at most 1. out: filled in for every result but a wrong `out` or size of
 * it, with a finite force within the limits, zero for a wrong argument; not kept. The guard takes a probe or a time step that
 * cannot be used for a position that is lost: its force falls, and PALPA_WRONG_ARGUMENT is returned. An invalid probe is no
 * failure. */
palpa_result palpa_hand_tick(palpa_hand* hand, const palpa_probe* probe, double time_step_s, palpa_command* out);

/* 1: zero force from the next tick on; 0: back by the guard's gate and ramp. NULL: nothing. Neither allocates nor locks. */
void palpa_hand_panic(palpa_hand* hand, int32_t on);

/* Takes the events of the data that came since the last call, the oldest first; the newest 64 are kept. Neither allocates nor
 * locks.
 * out: array of `room` events; out[0].size is the size of each. Returns how many were taken; 0 with a new palpa_last_error()
 * for NULL or a wrong size. */
size_t palpa_hand_events(palpa_hand* hand, palpa_event* out, size_t room);

/* ---- Loop: a session with the guard ---- */

/* Ticks of a session with all that docs/safety.md has between its force and a device, and with a recorder: what palpa run does,
 * on the program's own clock. */
typedef struct palpa_loop palpa_loop;

/* Circumstances of a tick besides the probe, as bits. */
enum {
  PALPA_DEVICE_FAULT = 1,
  PALPA_LINK_LOST = 2, /* the device did not take the last force */
  PALPA_LATE = 4,      /* three ticks or more were missed while the motors held the last force */
  PALPA_VIEW_MOVES = 8,
  PALPA_PANIC = 16, /* in each tick until a person resumes */
  PALPA_RESUME = 32
};

/* A primitive that a mode placed, in the hand frame. */
typedef struct palpa_primitive {
  uint32_t size;
  int32_t kind;         /* 0: point, 1: line, 2: plane, 3: directed force, 4: facet of a corner */
  int32_t mode;         /* [1] the mode's number */
  int32_t unused;       /* 0 */
  double position_m[3]; /* unused by a directed force */
  double direction[3];  /* [1] unit length; unused by a point */
  double strength_n;
  double force_n[3]; /* on the proxy, in the split of the law */
} palpa_primitive;

/* Begins a loop of the scene as it is now, within the limits of a device (the token is not used): `motors` chooses the whole
 * guard or the force limit alone. Returns what palpa_loop_free frees; NULL: failure, as for a volume larger than memory. */
palpa_loop* palpa_loop_new(const palpa_scene* scene, const palpa_limits* limits);

/* Frees a loop; a recording stays incomplete, but readable. NULL: nothing. */
void palpa_loop_free(palpa_loop* loop);

/* One tick. Neither allocates nor locks but, after a failure, for the thread's sentence.
 * time_step_s: since the last tick, above 0, at most 1. circumstances: bits. command: for the motors; its link, beyond, age and
 * round trip are 0. tick: of the session; NULL: not wanted. Returns PALPA_WRONG_ARGUMENT for arguments that cannot be used: the
 * guard then takes the position for lost, and the force falls. */
palpa_result palpa_loop_tick(palpa_loop* loop, const palpa_probe* probe, double time_step_s, uint32_t circumstances,
                             palpa_command* command, palpa_tick* tick);

/* Turns the hand's axes with the view: the probe is at rotation * handle, and forces are turned back for the motors; contact
 * begins anew. rotation: [1] 9 numbers by row, a proper rotation; others are refused. Does not allocate. */
palpa_result palpa_loop_turn(palpa_loop* loop, const double rotation[9]);

/* Feels another scene from the next tick on, where the hand is; the guard spreads the step of the force over its ramp. A
 * failure changes nothing. Not for a real-time thread. */
palpa_result palpa_loop_change(palpa_loop* loop, const palpa_scene* scene);

/* Events of the last tick, as palpa_session_events. */
size_t palpa_loop_events(const palpa_loop* loop, palpa_event* out, size_t room);

/* Primitives of the last tick's last sub-step. Neither allocates nor locks.
 * out: array of `room`, or NULL to count; out[0].size is the size of each. Returns their number, of which the first `room` are
 * in `out`; 0 with a new palpa_last_error() for NULL or a wrong size. */
size_t palpa_loop_primitives(const palpa_loop* loop, palpa_primitive* out, size_t room);

/* Force of a mode in the last tick. Neither allocates nor locks.
 * mode: [1] its number, from 0 in the scene's order. force_n: set. */
palpa_result palpa_loop_mode(const palpa_loop* loop, int32_t mode, double force_n[3]);

/* Begins a recording (docs/trace.md), of a session and a guard that begin anew, or ends one.
 * folder: of the trace; its parent exists, it does not; NULL: completes the trace. least_time_step_s: shortest time step that
 * will come, above 0; a longer one is a gap of as many ticks. device: its name for the trace; NULL: none. */
palpa_result palpa_loop_record(palpa_loop* loop, const char* folder, double least_time_step_s, const char* device);

/* ---- Hand that the program steers: pseudo-haptics ---- */

/* Hands without motors, by the rules of palpa-explorer's mouse and of palpa run --device controller: forces slow the hand. */
typedef struct palpa_steered palpa_steered;
enum {
  PALPA_MOUSE = 0,     /* moves by ways */
  PALPA_CONTROLLER = 1 /* a deflection moves it at a speed */
};

/* Input since the last read. */
typedef struct palpa_steering {
  uint32_t size;
  uint32_t buttons;     /* bits */
  double way_m[3];      /* of a mouse, in the hand frame */
  double deflection[3]; /* [1] of a controller, of the full one */
  int32_t is_put;       /* 1: the mouse's hand is put at put_m; the force should be withheld (PALPA_VIEW_MOVES); else 0 */
  int32_t unused;       /* 0 */
  double put_m[3];
} palpa_steering;

/* Begins a hand at rest in the middle of its reach. kind: PALPA_MOUSE or PALPA_CONTROLLER. limits: set, for palpa_loop_new,
 * where has_motors 1 adds the whole guard, so that panic and a moving view take the force away; NULL: not wanted. Returns what
 * palpa_steered_free frees; NULL: failure. */
palpa_steered* palpa_steered_new(int32_t kind, palpa_limits* limits);

/* Frees it. NULL: nothing. */
void palpa_steered_free(palpa_steered* hand);

/* Moves the hand for a time step, against the force that was written last. Does not allocate.
 * input: numbers that are not finite count as 0. time_step_s: above 0, at most 1. out: set. */
palpa_result palpa_steered_read(palpa_steered* hand, const palpa_steering* input, double time_step_s, palpa_probe* out);

/* Force of the guard's command, [N]. Not finite: zero. Does not allocate. */
palpa_result palpa_steered_write(palpa_steered* hand, const double force_n[3]);

/* ---- Inverse3: a device by Haply's Inverse Service, over a WebSocket of the program ---- */

/* Exchange of forces for states (docs/devices.md) by the rules of palpa run --device inverse3: the program has the WebSocket,
 * to ws://127.0.0.1:10001 as a rule, and the clock; messages are made and judged here. `now_s` [s] is the time of each call by
 * a steady clock with any zero: finite, never earlier than that of an earlier call, else the call fails and changes nothing. A
 * pause of the program, of any cause, is found by it and costs the force until the service has answered in time again. */
typedef struct palpa_inverse3 palpa_inverse3;

/* Keys of a force in messages. */
enum {
  PALPA_FORCE_BY_VERSION = 0, /* by the service's version; unknown: as below */
  PALPA_FORCE_VECTOR = 1,     /* service 3.5 and later */
  PALPA_FORCE_VALUES = 2      /* before */
};

/* Names: 1 to 64 letters, digits, '_', '-', '.' and ':'. */
typedef struct palpa_inverse3_options {
  uint32_t size;
  int32_t force_key;     /* PALPA_FORCE_BY_VERSION … PALPA_FORCE_VALUES */
  const char* version;   /* answer of the service's port to GET /version; NULL: unknown */
  const char* device_id; /* NULL: the first Inverse3 that the service lists, from then on that one */
  const char* grip_id;   /* of the grip that is the handle; NULL: the first with an orientation */
  const char* profile;   /* of the session, for the service; NULL: "palpa:palpa" */
} palpa_inverse3_options;

/* What the program has to do. */
enum {
  PALPA_INVERSE3_NOTHING = 0,
  PALPA_INVERSE3_CONNECT = 1, /* open a WebSocket; refused or lost: palpa_inverse3_take(inverse3, NULL, 0, now_s) */
  PALPA_INVERSE3_CLOSE = 2,   /* close it, with code 1000, and pass on nothing of it any more but that it is closed */
  PALPA_INVERSE3_DONE = 3     /* after palpa_inverse3_end: nothing, any more */
};

/* Limits of the device, for the guard: as those of the native one. out: size set; filled in. Returns PALPA_WRONG_ARGUMENT for
 * NULL or a wrong size. Any thread; does not allocate. */
palpa_result palpa_inverse3_limits(palpa_limits* out);

/* Begins an exchange. options: not kept; NULL: all zero. Returns what palpa_inverse3_free frees; NULL: failure. */
palpa_inverse3* palpa_inverse3_new(const palpa_inverse3_options* options);

/* Frees it, without a further message: palpa_inverse3_end first. NULL: nothing. */
void palpa_inverse3_free(palpa_inverse3* inverse3);

/* Checks deadlines; to be called after each event and every few milliseconds. Returns PALPA_INVERSE3_NOTHING …
 * PALPA_INVERSE3_DONE; negative: failure. */
int32_t palpa_inverse3_look(palpa_inverse3* inverse3, double now_s);

/* Takes a message of the service.
 * text: whole, UTF-8; NULL with bytes 0: the connection was refused, lost or closed. Returns PALPA_WRONG_DATA for a message
 * that is none of an Inverse Service, or that was not asked for: it is passed over; after three in a row palpa_inverse3_look
 * returns PALPA_INVERSE3_CLOSE. */
palpa_result palpa_inverse3_take(palpa_inverse3* inverse3, const char* text, size_t bytes, double now_s);

/* Writes the message that is due, to be sent at once as text; to be called after palpa_inverse3_look, once all messages that
 * have come were taken and the last that was given is sent. room: [bytes] at `text`, at least PALPA_MESSAGE_BYTES. Returns its
 * length [bytes], without a zero behind it; 0: none is due, or with a new palpa_last_error() for a wrong argument. */
size_t palpa_inverse3_give(palpa_inverse3* inverse3, char* text, size_t room, double now_s);

/* State of the device, at most 50 ms old.
 * out: size set; `valid` 0 where the position cannot be used, with no buttons; `turn` of the grip, without one no rotation.
 * fault: set to a static text, why there is no force, or NULL for none; NULL: not wanted. Does not allocate. */
palpa_result palpa_inverse3_read(palpa_inverse3* inverse3, palpa_probe* out, const char** fault, double now_s);

/* Force for the next message. UNGUARDED: give the command of palpa_loop_tick, in the limits of palpa_inverse3_limits. It is
 * sent within the device's limit, without a fault and within 20 ms, and else not at all. force_n: [N] x, y, z; not finite:
 * zero. Does not allocate. */
palpa_result palpa_inverse3_write(palpa_inverse3* inverse3, const double force_n[3], double now_s);

/* Ends: palpa_inverse3_give has a force of zero at once, also before the pending answer; PALPA_INVERSE3_DONE comes within
 * 250 ms. Does not allocate. */
palpa_result palpa_inverse3_end(palpa_inverse3* inverse3, double now_s);

#ifdef __cplusplus
}
#endif

#endif

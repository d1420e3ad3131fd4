// Messages between the page and the Worker that ticks. SI units, hand frame unless said otherwise.

/** Position or vector: x, y, z. */
export type Vec3 = [number, number, number];

/** One array of a file, on an affine grid of the world: voxel (i, j, k) is at origin_m + i axes_m[0] + j axes_m[1] + k axes_m[2]. */
export interface GivenField {
  name: string;
  unit: string;
  type: 'uint8' | 'int16' | 'uint16' | 'int32' | 'float32' | 'float64';
  components: 1 | 3;
  dims: Vec3;
  origin_m: Vec3;
  axes_m: [Vec3, Vec3, Vec3];
  slope: number;
  intercept: number;
  voxels: ArrayBuffer;
}

/** A file that the page has read. */
export interface GivenFile {
  name: string; // as a scene's 'file' names it
  format: string; // 'nrrd', 'nifti', 'meta', 'dicom'
  modality: string; // 'CT', 'MR' or ''
  length_unit: string;
  length_unit_assumed: boolean;
  medical_frame: boolean; // the world is LPS
  bytes: number; // of all its files
  sha256: string; // of the file that 'name' names, '' where the browser has no SHA-256 (a page without https)
  sources: { name: string; bytes: number; sha256: string }[]; // all its files, that one first: a trace names each
  fields: GivenField[];
}

export type ToWorker =
  | { kind: 'scene'; name: string; text: string } // feels the scene of this TOML text; its files were given
  | { kind: 'file'; file: GivenFile } // gives a file; answered by 'file' with facts and first scene
  | { kind: 'set'; path: string; value: string } // as --set PATH=VALUE; the hand continues where it is
  | { kind: 'sample'; field: string; longest: number } // answered by 'field', at most so many voxels along an edge
  | { kind: 'device'; device: 'mouse' | 'controller' | 'inverse3' }
  | { kind: 'pointer'; way_m: Vec3 } // motion of the mouse's hand
  | { kind: 'put'; position_m: Vec3 }
  | { kind: 'buttons'; buttons: number }
  | { kind: 'deflection'; share: Vec3; buttons: number } // of a controller, of full deflection
  | { kind: 'view_moves'; moves: boolean } // zero force while the view moves
  | { kind: 'turn'; rotation: number[] } // 9 numbers by row: from the hand's axes to the hand frame: a push to the right moves to the right of the screen
  | { kind: 'panic'; on: boolean }
  | { kind: 'record'; on: boolean } // the end is answered by 'trace'
  | { kind: 'rest' } // hidden page: zero force, no ticks until the next input; an Inverse3 is let go
  | { kind: 'wake' }; // visible page: an Inverse3 is taken again

export interface FieldFacts {
  name: string; // 'volume.field'
  unit: string;
  components: number;
  range: [number, number]; // least and largest value, of the magnitude for vectors
  histogram: number[]; // counts in equal steps of the range
}

export interface LevelFacts {
  name: string;
  value: number;
  strength_n: number;
  path: string; // 'mode.skin.level.skin': 'set' takes path + '.value' and path + '.strength_n'
}

export interface ModeFacts {
  name: string;
  type: string;
  field: string; // its first field, '' for none
  enabled: boolean; // 'set' takes 'mode.NAME.enabled'
  strength_n: number | null; // 'set' takes 'mode.NAME.strength_n'; null: the mode has none of its own
  levels: LevelFacts[];
}

/** A layer of the scene's picture, [[view.layer]]. */
export interface LayerFacts {
  show: 'surface' | 'streamlines';
  field: string; // as FieldFacts.name
  name: string;
  level: number | null; // of a surface
  color: string; // '#rrggbb' or ''
  opacity: number; // [1]
}

export interface SceneFacts {
  title: string;
  text: string; // TOML with everything that was set
  warnings: string[];
  fields: FieldFacts[];
  modes: ModeFacts[];
  layers?: LayerFacts[]; // other kinds are left out; absent: the page draws the modes' levels, and streamlines of vectors
  hand_to_world: number[]; // 16 numbers by row
  reach_m: number; // radius of the ball of the mouse's hand
  bounds_m: [Vec3, Vec3]; // of the volumes, in the world
  stiffness_n_per_m: number;
  max_force_n: number;
}

export interface PlacedPrimitive {
  kind: 'point' | 'line' | 'plane' | 'corner' | 'force';
  mode: number;
  position_m: Vec3;
  direction: Vec3;
  strength_n: number;
  force_n: Vec3;
}

/** State for a picture, about 60 times a second. */
export interface Moment {
  tick: number;
  t_s: number;
  probe_m: Vec3;
  proxy_m: Vec3;
  force_n: Vec3; // of the coupling
  command_n: Vec3; // after the guard
  guard: string; // 'pass', 'limited', 'fault', 'waiting', 'ramp', 'damped', 'falling', 'off'
  cause: string; // '' or words: 'the hand is too fast'
  modes_n: Vec3[]; // force of each mode
  primitives: PlacedPrimitive[];
  events: string[]; // since the last moment: 'onset skin', 'break-through bone'
  force_curve: Float32Array; // |command| [N] of each tick since the last moment
  energy_j: { stored: number; dissipated: number; injected: number; released: number; damper: number };
  tick_us: number; // mean time of the last thousands of ticks
  device: string; // its state in words: '' or 'the Inverse Service is not there'
}

export type FromWorker =
  | { kind: 'ready'; version: string }
  | { kind: 'opened'; scene: SceneFacts }
  | { kind: 'changed'; scene: SceneFacts } // after 'set'
  | { kind: 'file'; name: string; facts: string; first_scene: string } // facts: lines as `palpa info` prints them
  | { kind: 'field'; field: string; unit: string; dims: Vec3; origin_m: Vec3; axes_m: [Vec3, Vec3, Vec3]; values: Float32Array } // world; of vectors x, y, z of each voxel along the world's axes (three times as many numbers), or the magnitude
  | { kind: 'moment'; moment: Moment }
  | { kind: 'trace'; folder: string; files: { name: string; bytes: Uint8Array }[] }
  | { kind: 'failed'; of: ToWorker['kind']; sentence: string }; // one line: PLACE: what is wrong; what would be right

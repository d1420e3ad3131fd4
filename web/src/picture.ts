// Picture of a scene: fields as they arrive, surfaces of levels, streamlines, cloud, slices.

import type { Box, Camera } from './camera';
import { surface_color } from './colors';
import { number_words } from './dom';
import { inverted, map_point } from './geometry';
import type { FeltSurfaces, Hand } from './hand';
import { field_named } from './panel';
import type { FieldFacts, LayerFacts, SceneFacts, ToWorker, Vec3 } from './protocol';
import { SampledField, type FieldMessage } from './sampled_field';
import type { Slices, Window } from './slices';
import { streamlines } from './streamlines';
import { Surfaces } from './surfaces';
import type { Surface } from './surface_worker';
import type { SurfaceLook, View } from './view';

const first_longest = 56; // voxels along an edge of the first sample. More: the first touch comes late; fewer: it is beside what is seen
const longest = 160; // of the second. More: memory, seconds; fewer: facets
const longest_of_vectors = 64;
const longest_of_derived = 96; // which cost derivatives at each voxel

interface Drawn extends SurfaceLook {
  key: string;
  name: string;
  field: string;
  level: number;
}

export interface LegendEntry {
  name: string;
  color: string;
}

export class Picture {
  shows_cloud = false;
  is_medical = false;
  on_legend: (entries: LegendEntry[]) => void = () => {};
  on_slice_field: (names: string[], shown: string) => void = () => {};
  private scene: SceneFacts | null = null;
  private fields = new Map<string, SampledField>();
  private slice_field = '';
  private readonly looks = new Map<string, SurfaceLook>();
  private readonly surfaces = new Surfaces();
  private seen_box: Box | null = null;
  private is_view_own = false;
  private has_interactor = false;

  constructor(
    private readonly view: View | null,
    private readonly camera: Camera,
    private readonly slices: Slices,
    private readonly hand: Hand,
    private readonly send: (message: ToWorker) => void,
  ) {
    this.surfaces.on_made = (wanted, surface, map, is_coarse) => this.show_surface(wanted.key, surface, map, is_coarse);
  }

  begin(scene: SceneFacts): void {
    for (const key of this.view?.keys() ?? []) this.view!.hide(key);
    for (const key of this.looks.keys()) this.surfaces.forget(key);
    this.looks.clear();
    this.fields.clear();
    this.hand.streams = [];
    this.seen_box = null;
    this.is_view_own = false;
    this.slice_field = first_field(scene)?.name ?? '';
    this.scene = scene;
    this.slices.begin(null, { low: 0, high: 1 }, this.is_medical);
    this.show_all();
    this.hand.begin_scene(box_of_volumes(scene).high_m[2]);
    const fields = needed(scene);
    for (const field of fields) this.request(field, field.components === 3 ? longest_of_vectors : first_longest);
    for (const name of derived(scene)) this.send({ kind: 'sample', field: name, longest: longest_of_derived });
    for (const field of fields) if (field.components === 1) this.request(field, longest);
    this.on_slice_field(scene.fields.map((field) => field.name), this.slice_field);
    this.update(scene);
  }

  /** Levels and modes have changed. */
  update(scene: SceneFacts): void {
    this.scene = scene;
    const drawn = surfaces_of(scene);
    for (const key of [...this.looks.keys()])
      if (!drawn.some((one) => one.key === key)) {
        this.looks.delete(key);
        this.surfaces.forget(key);
        this.view?.hide(key);
      }
    for (const one of drawn) {
      this.looks.set(one.key, one);
      const field = this.fields.get(one.field);
      if (field && this.view) this.surfaces.want({ key: one.key, field, level: one.level });
    }
    this.hand.surfaces = felt_surfaces(scene, this.fields);
    this.hand.is_ready = needed(scene).every((field) => this.fields.has(field.name));
    this.on_legend(legend_of(drawn));
  }

  take(message: FieldMessage): void {
    const { scene } = this;
    if (!scene || !(scene.fields.some((field) => field.name === message.field) || derived(scene).includes(message.field))) return;
    const field = new SampledField(message, scene.hand_to_world);
    this.fields.set(field.name, field);
    if (field.name === this.slice_field) this.begin_slices(field);
    if (field.vectors) this.draw_streamlines(field);
    if (this.shows_cloud) void this.show_cloud(true);
    this.update(scene);
  }

  /** Another field in the slices. */
  slice(name: string): void {
    this.slice_field = name;
    const field = this.fields.get(name);
    const facts = this.scene?.fields.find((one) => one.name === name);
    if (field) this.begin_slices(field);
    else if (facts) this.request(facts, facts.components === 3 ? longest_of_vectors : longest);
  }

  /** A cloud takes the surfaces' place, which would hide it. */
  async show_cloud(shows: boolean): Promise<void> {
    this.shows_cloud = shows;
    this.view?.show_surfaces(!shows);
    const field = this.fields.get(this.slice_field);
    const facts = this.scene?.fields.find((one) => one.name === this.slice_field);
    if (!shows || !field || !facts || !this.view) return this.view?.hide('cloud');
    const { cloud_of, new_interactor } = await import('./cloud');
    if (!this.has_interactor) this.view.set_interactor(new_interactor());
    this.has_interactor = true;
    const { low, high } = window_of(facts);
    this.view.show('cloud', cloud_of(field, low, high, field.vectors !== null));
  }

  show_all(): void {
    if (!this.scene) return;
    this.camera.show_all(this.seen_box ?? box_of_volumes(this.scene));
    this.view?.draw();
  }

  /** The person has turned or zoomed: the view stays where it is. */
  keep_view(): void {
    this.is_view_own = true;
  }

  private request(field: FieldFacts, edge: number): void {
    this.send({ kind: 'sample', field: field.name, longest: edge });
  }

  private begin_slices(field: SampledField): void {
    const facts = this.scene!.fields.find((one) => one.name === field.name)!;
    this.slices.begin(field, window_of(facts), this.is_medical);
    this.on_slice_field(this.scene!.fields.map((one) => one.name), field.name);
  }

  private draw_streamlines(field: SampledField): void {
    const facts = this.scene!.fields.find((one) => one.name === field.name)!;
    const lines = streamlines(field, facts.range[1]);
    this.hand.streams = lines;
    this.view?.set_lines('streamlines ' + field.name, lines);
    if (!this.seen_box && lines.length > 0) this.see(lines.flatMap((line) => line.points_m));
  }

  private show_surface(key: string, surface: Surface, map: number[], is_coarse: boolean): void {
    const look = this.looks.get(key);
    if (!look || !this.view) return;
    this.view.set_surface(key, surface, map, look, is_coarse);
    const points: Vec3[] = [];
    for (let t = 1; t < surface.triangles.length; t += 40) {
      const at = 3 * surface.triangles[t];
      points.push(map_point(map, [surface.points[at], surface.points[at + 1], surface.points[at + 2]]));
    }
    this.see(points);
  }

  /** Widens what the view shows, until the person has turned it. */
  private see(points_m: Vec3[]): void {
    if (points_m.length === 0) return;
    const box = this.seen_box ?? { low_m: [...points_m[0]] as Vec3, high_m: [...points_m[0]] as Vec3 };
    for (const at_m of points_m)
      for (let n = 0; n < 3; ++n) {
        box.low_m[n] = Math.min(box.low_m[n], at_m[n]);
        box.high_m[n] = Math.max(box.high_m[n], at_m[n]);
      }
    this.seen_box = box;
    if (!this.is_view_own) this.show_all();
  }
}

function first_field(scene: SceneFacts): FieldFacts | undefined {
  const with_levels = scene.modes.find((mode) => mode.levels.length > 0 && field_named(scene, mode.field));
  const mode = with_levels ?? scene.modes.find((one) => field_named(scene, one.field));
  return mode ? field_named(scene, mode.field) : scene.fields[0];
}

/** Fields of the modes and layers; in a scene without either its first one. */
function needed(scene: SceneFacts): FieldFacts[] {
  const names = new Set<string>();
  const first = first_field(scene);
  if (first) names.add(first.name);
  for (const mode of scene.modes) {
    const field = field_named(scene, mode.field);
    if (field && (mode.levels.length > 0 || field.components === 3)) names.add(field.name);
  }
  for (const layer of scene.layers ?? []) names.add(layer.field);
  return scene.fields.filter((field) => names.has(field.name));
}

/** Fields of layers that are derived from others, such as 'q(wing.velocity)'. */
function derived(scene: SceneFacts): string[] {
  const names = (scene.layers ?? []).filter((layer) => layer.show === 'surface').map((layer) => layer.field);
  return [...new Set(names)].filter((name) => !scene.fields.some((field) => field.name === name));
}

function surfaces_of(scene: SceneFacts): Drawn[] {
  const layers = (scene.layers ?? []).filter((layer) => layer.show === 'surface' && layer.level !== null);
  if (layers.length > 0) return layers.map((layer, n) => of_layer(scene, layer, n));
  const drawn: Drawn[] = [];
  for (const mode of scene.modes) {
    const field = field_named(scene, mode.field);
    if (!field || !mode.enabled) continue;
    for (const level of mode.levels)
      drawn.push({ key: 'surface of ' + level.path, name: level.name, field: field.name, level: level.value, color: '', opacity: 1 });
  }
  drawn.sort((a, b) => a.level - b.level);
  // Enclosing surfaces are clear, enclosed ones are not.
  return drawn.map((one, n) => ({ ...one, color: surface_color(n), opacity: n + 1 < drawn.length ? 0.35 : 1 }));
}

/** A layer without a name has that of the level that is felt there. */
function of_layer(scene: SceneFacts, layer: LayerFacts, n: number): Drawn {
  const level = felt_levels(scene).find((one) => one.field === layer.field && one.value === layer.level);
  return {
    key: `surface ${n}`,
    name: layer.name || level?.name || layer.field,
    field: layer.field,
    level: layer.level!,
    color: /^#[0-9a-f]{6}$/i.test(layer.color) ? layer.color : surface_color(n),
    opacity: layer.opacity,
  };
}

/** Surfaces of one name have their level, too. */
function legend_of(drawn: Drawn[]): LegendEntry[] {
  return drawn.map(({ name, color, level }) => {
    const is_alone = drawn.filter((one) => one.name === name).length === 1;
    return { name: is_alone ? name : `${name} ${number_words(level)}`, color };
  });
}

interface FeltLevel {
  field: string;
  name: string;
  value: number;
}

/** Levels of modes that are on and have a strength. */
function felt_levels(scene: SceneFacts): FeltLevel[] {
  return scene.modes.filter((mode) => mode.enabled).flatMap((mode) => {
    const field = field_named(scene, mode.field)?.name;
    const levels = mode.levels.filter((level) => level.strength_n > 0);
    return field ? levels.map(({ name, value }) => ({ field, name, value })) : [];
  });
}

/** Surfaces that a press touches: levels; without them what is drawn, unless vectors are felt, where a shell is no obstacle. */
function felt_surfaces(scene: SceneFacts, fields: Map<string, SampledField>): FeltSurfaces[] {
  const feels_vectors = scene.modes.some((mode) => field_named(scene, mode.field)?.components === 3);
  let felt: { field: string; value: number }[] = felt_levels(scene);
  if (felt.length === 0 && !feels_vectors) felt = surfaces_of(scene).map(({ field, level }) => ({ field, value: level }));
  return [...fields.values()]
    .map((field) => ({ field, levels: felt.filter((one) => one.field === field.name).map((one) => one.value) }))
    .filter(({ levels }) => levels.length > 0);
}

/** Values from dark to light: all but the rarest hundredth at each end; of CT what shows bone and skin. */
function window_of(field: FieldFacts): Window {
  if (field.unit === 'HU') return { low: -500, high: 1000 };
  const [low, high] = field.range, { histogram } = field;
  const all = histogram.reduce((sum, count) => sum + count, 0);
  const value_at = (share: number) => {
    let sum = 0;
    const n = histogram.findIndex((count) => (sum += count) >= share * all);
    return low + ((Math.max(0, n) + (share > 0.5 ? 1 : 0)) / Math.max(1, histogram.length)) * (high - low);
  };
  return all > 0 && value_at(0.99) > value_at(0.01) ? { low: value_at(0.01), high: value_at(0.99) } : { low, high };
}

function box_of_volumes(scene: SceneFacts): Box {
  const to_hand = inverted(scene.hand_to_world);
  const [low, high] = scene.bounds_m;
  const box: Box = { low_m: [Infinity, Infinity, Infinity], high_m: [-Infinity, -Infinity, -Infinity] };
  for (let corner = 0; corner < 8; ++corner) {
    const at_m = map_point(to_hand, [0, 1, 2].map((n) => ((corner >> n) & 1 ? high[n] : low[n])) as Vec3);
    for (let n = 0; n < 3; ++n) {
      box.low_m[n] = Math.min(box.low_m[n], at_m[n]);
      box.high_m[n] = Math.max(box.high_m[n], at_m[n]);
    }
  }
  return box;
}

// Mouse, fingers and keys over the picture. Left on the data touches, beside it turns; two fingers turn and zoom.

import type { Camera } from './camera';
import type { Hand } from './hand';
import type { Marks } from './marks';
import type { Vec3 } from './protocol';

const degrees_per_px = 0.4;
const key_step_px = 4; // of an arrow key. Longer: the hand jumps; shorter: a way takes many presses
const still_after_ms = 150; // from the last step of a wheel or key to a view at rest

type Drag = 'none' | 'touch' | 'turn' | 'move' | 'fingers';

export class Input {
  on_view: () => void = () => {}; // the view has changed
  on_view_moves: (moves: boolean) => void = () => {};
  on_touch: () => void = () => {};
  private drag: Drag = 'none';
  private last: [number, number] = [0, 0];
  private readonly fingers = new Map<number, [number, number]>();
  private rest_timer = 0;
  private view_moves = false;
  private hover_due = false;
  private by_keys = false;

  constructor(
    private readonly canvas: HTMLElement,
    private readonly camera: Camera,
    private readonly hand: Hand,
    private readonly marks: Marks,
  ) {
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', (event) => this.up(event));
    canvas.addEventListener('pointerleave', () => (this.marks.ghost_m = null));
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    canvas.addEventListener('keydown', (event) => this.key(event));
    canvas.addEventListener('blur', () => this.end_touch_by_keys());
  }

  get is_touching(): boolean {
    return this.drag === 'touch' || this.by_keys;
  }

  /** What is under a resting cursor has changed. */
  look_again(): void {
    if (this.drag === 'none' && !this.by_keys && this.canvas.matches(':hover')) this.hover();
  }

  /** Ends whatever is held: a hidden page gets no release. */
  let_go(): void {
    this.by_keys = false;
    this.fingers.clear();
    this.hand.end();
    this.set_drag('none');
  }

  look_from(from: Vec3, up: Vec3): void {
    this.camera.look_from(from, up);
    this.step_of_view();
  }

  zoom(factor: number): void {
    this.camera.zoom(factor);
    this.step_of_view();
  }

  private down(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true, focusVisible: false } as FocusOptions);
    this.end_touch_by_keys();
    this.canvas.setPointerCapture(event.pointerId);
    this.last = this.px(event);
    this.marks.ghost_m = null;
    if (event.pointerType === 'touch') {
      this.fingers.set(event.pointerId, this.px(event));
      if (this.fingers.size === 2) {
        this.hand.end();
        return this.set_drag('fingers');
      }
      if (this.fingers.size > 2) return;
    } else if (this.drag !== 'none') {
      return;
    }
    if (event.button === 1 || (event.button === 0 && event.shiftKey)) this.set_drag('move');
    else if (event.button === 0 && this.hand.begin(...this.last)) this.set_drag('touch');
    else this.set_drag('turn');
  }

  private move(event: PointerEvent): void {
    const at = this.px(event);
    if (this.drag === 'fingers') return this.move_fingers(event.pointerId, at);
    const way = [at[0] - this.last[0], at[1] - this.last[1]];
    this.last = at;
    if (this.drag === 'none' && !this.by_keys) this.hover();
    if (this.drag === 'touch') this.hand.lead(...at);
    if (this.drag === 'turn') this.camera.turn(degrees_per_px * way[0], degrees_per_px * way[1]);
    if (this.drag === 'move') this.camera.move(way[0], way[1]);
    if (this.drag === 'turn' || this.drag === 'move') this.on_view();
  }

  private up(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
    if (this.drag === 'fingers' && this.fingers.size > 0) return;
    if (this.drag === 'touch') this.hand.end();
    this.set_drag('none');
  }

  private move_fingers(id: number, at: [number, number]): void {
    const before = this.fingers.get(id);
    const other = [...this.fingers].find(([one]) => one !== id)?.[1];
    if (!before || !other) return;
    this.fingers.set(id, at);
    const away = (p: [number, number]) => Math.max(20, Math.hypot(p[0] - other[0], p[1] - other[1]));
    this.camera.zoom(away(at) / away(before));
    // The middle of two fingers moves half as far as each.
    this.camera.turn(0.5 * degrees_per_px * (at[0] - before[0]), 0.5 * degrees_per_px * (at[1] - before[1]));
    this.on_view();
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const per_notch = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 100 : 3;
    const notches = -event.deltaY / per_notch;
    if (this.is_touching) this.hand.press_deeper(notches);
    else this.zoom(Math.pow(1.15, notches));
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const ways: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const way = ways[event.key];
    const presses = event.key === 'PageDown' ? 1 : event.key === 'PageUp' ? -1 : 0;
    if (way && event.shiftKey) {
      this.camera.turn(20 * degrees_per_px * way[0], 20 * degrees_per_px * way[1]);
      this.step_of_view();
    } else if (way || presses !== 0) {
      if (!this.by_keys) this.begin_touch_by_keys();
      else if (way) this.hand.lead_by(key_step_px * way[0], key_step_px * way[1]);
      else this.hand.press_deeper(presses);
    } else if (event.key === 'Enter') {
      if (this.by_keys) this.end_touch_by_keys();
      else this.begin_touch_by_keys();
    } else if (event.key === 'Escape' && this.by_keys) {
      this.end_touch_by_keys();
    } else if (event.key === '+' || event.key === '-') {
      this.zoom(event.key === '+' ? 1.15 : 1 / 1.15);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  private begin_touch_by_keys(): void {
    const px = this.drag === 'none' ? this.hand.nearest_target_px() : null;
    if (!px || !this.hand.begin(...px)) return;
    this.by_keys = true;
    this.on_touch();
  }

  private end_touch_by_keys(): void {
    if (this.by_keys) this.hand.end();
    this.by_keys = false;
  }

  /** Cue of what a press does here, once a picture. */
  private hover(): void {
    if (this.hover_due) return;
    this.hover_due = true;
    requestAnimationFrame(() => {
      this.hover_due = false;
      if (this.drag !== 'none') return;
      const target = this.hand.target_at(...this.last);
      this.marks.ghost_m = target ? target.at_m : null;
      this.canvas.style.cursor = target ? 'pointer' : 'grab';
    });
  }

  private set_drag(drag: Drag): void {
    if (drag === 'touch') this.on_touch();
    this.drag = drag;
    this.canvas.style.cursor = drag === 'touch' ? 'crosshair' : drag === 'none' ? 'grab' : 'grabbing';
    this.set_view_moves(drag === 'turn' || drag === 'move' || drag === 'fingers');
  }

  /** One step of a key or wheel: the view moves until no other follows. */
  private step_of_view(): void {
    this.set_view_moves(true);
    clearTimeout(this.rest_timer);
    this.rest_timer = window.setTimeout(() => {
      if (this.drag === 'none' || this.drag === 'touch') this.set_view_moves(false);
    }, still_after_ms);
    this.on_view();
  }

  private set_view_moves(moves: boolean): void {
    if (moves === this.view_moves) return;
    this.view_moves = moves;
    this.on_view_moves(moves);
  }

  private px(event: PointerEvent): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
}

// Colours as in the native window.

export const proxy_color = '#16161c';

/** Okabe and Ito's set, which colour-blind people can tell apart. */
const mode_hexes = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9'];
const surface_hexes = ['#d99a7e', '#efe6d2', '#8fb0a9', '#a9a3c4', '#c9c9c9'];
/** "inferno" from 0.9 down to 0.2 (N. Smith, S. van der Walt, CC0). */
const force_hexes = ['#f6d746', '#fca50a', '#f37819', '#dd513a', '#bc3754', '#932667', '#6a176e', '#420a68'];
/** "mako" (M. Waskom, "seaborn", J. Open Source Softw. 6(60), 3021, 2021). */
const magnitude_hexes = ['#8ad9b1', '#40b7ad', '#348fa7', '#37659e', '#413d7b', '#2e1e3b'];

export const mode_color = (mode: number): string => mode_hexes[mode % mode_hexes.length];
export const surface_color = (number: number): string => surface_hexes[number % surface_hexes.length];

/** Red, green, blue [1] of '#rrggbb'. */
export function rgb(hex: string): [number, number, number] {
  const number = parseInt(hex.slice(1), 16);
  return [((number >> 16) & 255) / 255, ((number >> 8) & 255) / 255, (number & 255) / 255];
}

/** Red, green, blue in bytes. \param share  [1] 0…1 */
export const magnitude_bytes = (share: number) => between(magnitude_hexes, share);

export function force_style(share: number, opacity: number): string {
  const [red, green, blue] = between(force_hexes, share);
  return `rgba(${red}, ${green}, ${blue}, ${opacity})`;
}

function between(hexes: string[], share: number): [number, number, number] {
  const at = Math.min(1, Math.max(0, share || 0)) * (hexes.length - 1);
  const n = Math.min(Math.floor(at), hexes.length - 2);
  const low = rgb(hexes[n]), high = rgb(hexes[n + 1]);
  return [0, 1, 2].map((c) => Math.round(255 * (low[c] + (at - n) * (high[c] - low[c])))) as [number, number, number];
}

export const is_dark = (): boolean => matchMedia('(prefers-color-scheme: dark)').matches;

// SPDX-License-Identifier: MIT
// nqm for JavaScript. Names and units are those of the Python package: directions are unit vectors away from the surface with axes tangent,
// bitangent and normal; f_r is in 1/sr without the cosine, linear RGB with BT.709 primaries.

export class NqmError extends Error {
    /** nqm_status: -1 argument, -2 file, -3 format, -4 incompatible, -5 model, -6 memory, -7 limit, -8 numeric, -9 cancelled */
    status: number;
    /** position of the fault in its file; -1: none */
    byte: number;
}

export interface Score {
    /** 10: no visible difference; one JOD less: 75 % of people prefer the reference */
    jod: number;
    /** ends of the 95 % interval; null: the model has none */
    low: number | null;
    high: number | null;
    delta_e: number | null;
    novelty: number | null;
    verdict: string;
    words: string;
    /** mean difference of I, T and P in units of Delta-E: brighter, bluer, redder */
    shift: (number | null)[];
    contrast: number | null;
    structure: number | null;
    /** JOD of the materials seen apart, and the ends of its interval */
    apart: (number | null)[];
    anisotropy: number;
    prefer_reference: number;
    identical: boolean;
    metrics: Record<string, number | null>;
    n_valid: number;
    remarks: string[];
}

export interface Failure { error: string; status: number; byte: number }

export class BRDF {
    readonly id: number;
    readonly format: string;
    readonly name: string;
    /** canonical spec of an analytic model; null: none */
    readonly spec: string | null;
    readonly doi: string | null;
    readonly layout: string | null;
    readonly n_values: number;
    readonly n_bytes: number;
    readonly reciprocal: boolean;
    readonly isotropic: boolean;
    /** f_r (n, 3) at pairs of directions (n, 3); NaN where there is no value */
    eval(wi: ArrayLike<number>, wo: ArrayLike<number>): Float64Array;
    /** free it; it must not be used afterwards */
    close(): void;
}

export interface Material {
    name: string;
    surface: string | null;
    /** argument of open(); null: refused */
    spec: string | null;
    refusal: string | null;
    remark: string | null;
    n_maps: number;
    byte: number;
}

export interface TextureScore {
    far: number | null;
    /** JOD of the median texel, and of the 5 % with the largest Delta-E */
    median: number;
    worst: number;
    /** share of texels below JOD 9 */
    below9: number;
    width: number;
    height: number;
    n_scored: number;
    /** near score with one property of the test alone, worst first, and a known mistake or "" */
    blame: {key: string; jod: number; mistake: string}[];
    /** Delta-E of the texels in viridis from 0 to end, RGBA */
    heat: {width: number; height: number; pixels: Uint8ClampedArray};
    end: number;
}

/** A picture that the caller has decoded, RGBA (height, width, 4), as a file for `files`. */
export function rawPicture(width: number, height: number, pixels: Uint8Array | Uint8ClampedArray): Uint8Array;

export interface Key { name: string; n: number; low: number; high: number; fallback: number | null; required: boolean }

export type Light = "studio" | "overcast" | "sun";

export interface Nqm {
    readonly version: string;
    readonly presets: string[];
    readonly models: {name: string; keys: Key[]}[];
    /** words for translate() */
    readonly targets: string[];
    /** the files that open() and materials() see: path to bytes. translate() writes here */
    readonly files: Map<string, Uint8Array>;
    /** called during translate() with the fraction done; return false to stop */
    onProgress: ((done: number) => boolean | void) | null;
    open(pathOrSpec: string): BRDF;
    /** a BRDF from a function that fills rgb (n, 3); n is at most 512 */
    fromFunction(evaluate: (n: number, wi: Float64Array, wo: Float64Array, rgb: Float64Array) => void, name?: string): BRDF;
    materials(path: string): Material[];
    score(ref: BRDF | string, test: BRDF | string, model?: "default" | "transport"): Score;
    scoreMany(pairs: [string, string][], model?: "default" | "transport"): (Score | Failure)[];
    /** near score of two materials of which one at least has image maps. PNG, JPEG and WebP maps must be in `files` as rawPicture() */
    scoreTextures(ref: string, test: string): Score & {texture: TextureScore};
    /** theta_h, theta_d, phi_d in degrees (n, 3) of the directions at which BRDFs are compared */
    directions(): Float64Array;
    /** f_r (4, 181, 3): around the mirror direction, and in the plane of incidence with the light at 10, 45 and 75 degrees */
    slices(brdf: BRDF, phi?: number): Float64Array;
    /** mean |difference of log(f_r + 0.003)| (60, 90) over theta_d and the root of theta_h; NaN below the horizon */
    differenceMap(ref: BRDF, test: BRDF): Float64Array;
    /** rows of theta_h, theta_d, phi_d in degrees, share of the visible difference, luminance of reference and test */
    costs(ref: BRDF, test: BRDF): number[][];
    /** a lit sphere, RGBA (size, size, 4); member 0 reference, 1 test */
    render(brdf: BRDF, member?: 0 | 1, options?: {light?: Light; size?: number; supersample?: number; turn?: number}): Uint8ClampedArray;
    /** Delta-E ITP between the last two pictures in viridis, from 0 to end; pixels: RGBA (size, size, 4); valid: the fractions of the light
     *  at directions where reference and test have a value: without one, the pictures are too dark */
    difference(size: number): {pixels: Uint8ClampedArray; end: number; valid: [number, number]};
    /** fit a shading model, write it to path in `files`, and score what was written */
    translate(brdf: BRDF, target: string, name: string, path: string): {spec: string; selected: string; dropped: string; score: Score};
}

export function load(): Promise<Nqm>;

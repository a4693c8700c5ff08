// SPDX-License-Identifier: MIT
//
// BRDFs written in GLSL, evaluated by WebGL2: a function vec3 BRDF(vec3 L, vec3 N, vec3 V, vec3 X, vec3 Y), f_r in 1/sr without the
// cosine, and the parameters of Disney's .brdf files between "::begin parameters" and "::end parameters" (float NAME LOW HIGH VALUE,
// color NAME R G B, bool NAME VALUE), which become uniforms.

const WIDTH = 512; // pairs of directions of a call, as nqm_brdf_eval_fn

const VERTEX = `#version 300 es
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3. : -1., gl_VertexID == 2 ? 3. : -1., 0., 1.); }`;

const HEAD = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2D nqm_light, nqm_viewer;
out vec4 nqm_value;
`;

const MAIN = `
void main() {
    ivec2 nqm_at = ivec2(gl_FragCoord.xy);
    vec3 L = texelFetch(nqm_light, nqm_at, 0).xyz, V = texelFetch(nqm_viewer, nqm_at, 0).xyz;
    nqm_value = vec4(BRDF(L, vec3(0., 0., 1.), V, vec3(1., 0., 0.), vec3(0., 1., 0.)), 1.);
}`;

/** The parameters and the shader of a text: {parameters: [{type, name, low, high, value}], body, line: of the body's first line}. */
export function parseGlsl(text) {
    const parameters = [], lines = text.replace(/\r\n?/g, "\n").split("\n");
    const find = (word) => lines.findIndex((line) => line.trim() === word);
    const first = find("::begin parameters"), last = find("::end parameters");
    if ((first < 0) !== (last < 0) || last < first) throw new Error("'::begin parameters' and '::end parameters' must both be given");
    for (let i = first + 1; first >= 0 && i < last; ++i) {
        const words = lines[i].replace(/#.*|\/\/.*/, "").trim().split(/\s+/);
        if (!words[0]) continue;
        const [type, name, ...numbers] = words, v = numbers.map(Number);
        const n = {float: 3, color: 3, bool: 1}[type];
        if (!n || !/^[A-Za-z_]\w*$/.test(name ?? "") || v.length !== n || v.some((x) => !isFinite(x)))
            throw new Error(`line ${i + 1}: a parameter is 'float NAME LOW HIGH VALUE', 'color NAME R G B' or 'bool NAME VALUE'`);
        parameters.push(type === "float" ? {type, name, low: v[0], high: v[1], value: v[2]} : {type, name, value: type === "color" ? v : v[0]});
    }
    const begin = find("::begin shader"), end = find("::end shader");
    const from = begin >= 0 ? begin + 1 : last >= 0 ? last + 1 : 0;
    const body = lines.slice(from, end >= 0 ? end : undefined).filter((line) => !/^\s*#version/.test(line)).join("\n");
    if (!/\bvec3\s+BRDF\s*\(/.test(body)) throw new Error("there is no function vec3 BRDF(vec3 L, vec3 N, vec3 V, vec3 X, vec3 Y)");
    return {parameters, body, line: from + 1};
}

/** An evaluator of a text: {parameters, values, evaluate(n, wi, wo, rgb), free()}. Throws what the compiler says. */
export function makeGlsl(text) {
    const {parameters, body, line} = parseGlsl(text);
    const gl = new OffscreenCanvas(WIDTH, 1).getContext("webgl2");
    if (!gl || !gl.getExtension("EXT_color_buffer_float")) throw new Error("this browser has no WebGL 2 with float render targets");
    const declarations = parameters.map(({type, name}) => `uniform ${{float: "float", color: "vec3", bool: "bool"}[type]} ${name};\n`);
    function compile(type, source) {
        const shader = gl.createShader(type);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        if (gl.getShaderParameter(shader, gl.COMPILE_STATUS)) return shader;
        const log = (gl.getShaderInfoLog(shader) ?? "").replace(/\0/g, "").trim();
        throw new Error(log.replace(/ERROR: \d+:(\d+):/g, "line $1:") || "the shader does not compile");
    }
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, HEAD + declarations.join("") + `#line ${line}\n` + body + MAIN));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "the shader does not link");
    gl.useProgram(program);
    const makeTexture = (unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, WIDTH, 1);
    };
    [0, 1, 2].forEach(makeTexture);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, gl.getParameter(gl.TEXTURE_BINDING_2D), 0);
    gl.uniform1i(gl.getUniformLocation(program, "nqm_light"), 0);
    gl.uniform1i(gl.getUniformLocation(program, "nqm_viewer"), 1);
    gl.viewport(0, 0, WIDTH, 1);
    const block = new Float32Array(4 * WIDTH), values = Object.fromEntries(parameters.map(({name, value}) => [name, value]));
    const upload = (unit, n, directions) => {
        for (let i = 0; i < 3 * n; ++i) block[Math.floor(i / 3) * 4 + (i % 3)] = directions[i];
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDTH, 1, gl.RGBA, gl.FLOAT, block);
    };
    return {
        parameters, values,
        evaluate(n, wi, wo, rgb) {
            for (const {type, name} of parameters) {
                const at = gl.getUniformLocation(program, name);
                if (type === "color") gl.uniform3fv(at, values[name]);
                else if (type === "bool") gl.uniform1i(at, Number(values[name]));
                else gl.uniform1f(at, values[name]);
            }
            upload(0, n, wi);
            upload(1, n, wo);
            gl.drawArrays(gl.TRIANGLES, 0, 3);
            gl.readPixels(0, 0, n, 1, gl.RGBA, gl.FLOAT, block);
            for (let i = 0; i < 3 * n; ++i) rgb[i] = block[Math.floor(i / 3) * 4 + (i % 3)];
        },
        free: () => gl.getExtension("WEBGL_lose_context")?.loseContext(),
    };
}

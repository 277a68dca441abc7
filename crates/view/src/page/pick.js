// Which body is seen at a place of the picture.

// The nearest place where a line from `from` along `along` meets one of these surfaces and `counts`: `{ surface, triangle, at }`,
// `at` in the coordinates of the mesh; or nothing.
function pick(data, surfaces, from, along, counts) {
  let nearest = Infinity, found;
  for (const surface of surfaces) {
    const { pose } = surface;
    const back = v => [0, 1, 2].map(i => pose[i] * v[0] + pose[4 + i] * v[1] + pose[8 + i] * v[2]);
    const [start, way] = [back(minus(from, [pose[3], pose[7], pose[11]])), back(along)];
    const [[first], [begin, count]] = data.form(surface, false);
    const corner = i => data.floats.subarray(first + 3 * data.words[i], first + 3 * data.words[i] + 3);
    for (let i = begin; i < begin + count; i += 3) {
      const t = crossing(start, way, corner(i), corner(i + 1), corner(i + 2));
      if (!(t > 0 && t < nearest)) continue;
      const at = start.map((value, k) => value + t * way[k]);
      if (!counts(placed(pose, at))) continue;
      nearest = t;
      found = { surface, triangle: (i - begin) / 3, at };
    }
  }
  return found;
}

// How far along its way a line meets a triangle; NaN if it does not.
function crossing(start, way, p, q, r) {
  const [e, f] = [minus(q, p), minus(r, p)];
  const across = cross(way, f);
  const scale = 1 / dot(e, across);
  const s = minus(start, p);
  const u = scale * dot(s, across);
  const turned = cross(s, e);
  const v = scale * dot(way, turned);
  return u >= 0 && v >= 0 && u + v <= 1 ? scale * dot(f, turned) : NaN;
}

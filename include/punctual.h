/*
 * punctual: mesh collision detection that answers by the deadline, and says how sure it is.
 *
 * Generated from crates/capi by tools/c_header; do not edit. The guide is docs/c.md. C99 or newer, or C++17 (punctual.hpp).
 *
 * Contents:
 *    1. Errors, and the version
 *    2. Points, boxes and poses
 *    3. Meshes
 *    4. Trees
 *    5. Two triangles
 *    6. Budgets and clocks
 *    7. Workspaces, and memory from frame to frame
 *    8. What answers have in common
 *    9. Intersection: do two surfaces meet?
 *   10. Distance: how far apart are they?
 *   11. Contacts: where do they touch?
 *   12. Motion: until when are they free?
 *   13. Penetration: how deep are they, and what parts them?
 *   14. Rays: what do they hit?
 *   15. Points: are they inside a solid?
 *   16. Scenes: many bodies, one budget a frame
 *   17. Robots: is a motion free?
 *   18. Calibration: probabilities that learn
 *
 * Errors. What can fail returns a punctual_status, and has then written no output. punctual_last_error() tells in words what
 * was wrong and where. No call ends the process, but for two cases that no library can return from: memory runs out while a
 * mesh, a tree or a scene grows, or a function of the caller's that was called back throws.
 *
 * Enumerations. A number that is passed in must be one of this header; others give PUNCTUAL_STATUS_BAD_ARGUMENT. A newer library
 * may return a punctual_status, a punctual_verdict or a punctual_stop_reason that this header does not have: each status but
 * PUNCTUAL_STATUS_OK is a failure, only PUNCTUAL_VERDICT_SEPARATED says that bodies are apart, and with a stop reason that is not
 * known here the answer is not complete.
 *
 * Pointers. Unless a function says otherwise, no pointer may be null; null gives PUNCTUAL_STATUS_NULL. A handle must be one
 * that was made by this library and not freed since. Other pointers must be aligned, and point to as many elements as the
 * length beside them says, or to a text that ends with a zero byte. An output may be uninitialised, but for its size; no output
 * may overlap another argument of the same call.
 *
 * Structs. One that begins with `size` may get more fields, at its end. What punctual_*_new and punctual_*_default return has its
 * size; of others set it first: `punctual_outcome outcome = {.size = sizeof outcome};`. Of an array of structs that may grow, pass
 * the size of one element beside its length, as to qsort. Then a program and a library of different versions work together: what
 * a struct lacks has its default where it is read, and is not written; fields that the library does not have must be 0 where
 * they are read, which *_new and *_default see to, and become 0 where they are written. Sizes that a struct cannot have give
 * PUNCTUAL_STATUS_BAD_ARGUMENT. All other structs stay as they are.
 *
 * Ownership. What *_new, punctual_mesh_read*, punctual_workspace_with_capacity, punctual_shape_*, punctual_tree_mesh,
 * punctual_tree_from_bytes and punctual_scene_tree make is the caller's, to be freed by the *_free of its type, in any order.
 * Everything that is passed in is copied or shared, never taken over, but for the trees of a punctual_query or
 * punctual_distance_query, which it borrows.
 *
 * Threads. Any number of threads may use a handle through pointers to const. A call that takes a handle that is not const
 * needs it for itself alone. Nothing is bound to the thread that made it. punctual_last_error() is each thread's own.
 *
 * Units. One length unit, the caller's, for all coordinates; matrices row by row; time in nanoseconds; triangles and vertices
 * counted from 0.
 */

#ifndef PUNCTUAL_H
#define PUNCTUAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** The version of this header. */
#define PUNCTUAL_VERSION "0.1.0"

#ifdef __cplusplus
#define PUNCTUAL_INLINE inline
extern "C" {
#else
#define PUNCTUAL_INLINE static inline
#endif

/* --------------------------------------------------------------------------------------------------------------------
 * 1. Errors, and the version
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * How a call ended. Unless it is `PUNCTUAL_STATUS_OK`, nothing was written to the outputs and
 * nothing was changed (but see `PUNCTUAL_STATUS_PANIC`), and `punctual_last_error` has a text
 * that names the place.
 */
enum punctual_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Done.
   */
  PUNCTUAL_STATUS_OK = 0,
  /**
   * A pointer that must not be null is null.
   */
  PUNCTUAL_STATUS_NULL = 1,
  /**
   * A number is out of its range: an unknown value of an enumeration, an index or a length,
   * or NaN.
   */
  PUNCTUAL_STATUS_BAD_ARGUMENT = 2,
  /**
   * Vertices and triangles are no mesh, or new vertices do not fit it.
   */
  PUNCTUAL_STATUS_BAD_MESH = 3,
  /**
   * Numbers are no pose: not finite, no rotation, or too far out.
   */
  PUNCTUAL_STATUS_BAD_POSE = 4,
  /**
   * A body id is not valid in this scene.
   */
  PUNCTUAL_STATUS_NO_SUCH_BODY = 5,
  /**
   * The scene has no id left.
   */
  PUNCTUAL_STATUS_SCENE_FULL = 6,
  /**
   * The workspace does not hold a run of this query: same trees, pose and options.
   */
  PUNCTUAL_STATUS_NOT_RESUMABLE = 7,
  /**
   * A tree is unsound. None that was built here is.
   */
  PUNCTUAL_STATUS_BAD_TREE = 8,
  /**
   * There is not that much memory.
   */
  PUNCTUAL_STATUS_OUT_OF_MEMORY = 9,
  /**
   * The operating system gives no thread.
   */
  PUNCTUAL_STATUS_NO_THREAD = 10,
  /**
   * An earlier call ended with `PUNCTUAL_STATUS_PANIC` while it changed this handle, which
   * can only be freed now.
   */
  PUNCTUAL_STATUS_POISONED = 11,
  /**
   * A fault of the library was caught. The handles that the call was to change are poisoned.
   */
  PUNCTUAL_STATUS_PANIC = 12,
  /**
   * A file cannot be read, or it, or its bytes, hold no mesh or no tree, or are damaged.
   */
  PUNCTUAL_STATUS_BAD_FILE = 13,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_status punctual_status;
#else
typedef uint32_t punctual_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The text of the last call on this thread that failed, in UTF-8: the function, the place and the
 * fault. Empty if none did. Valid until the next call on this thread that fails; calls that
 * succeed leave it.
 */
const char *punctual_last_error(void);

/**
 * The version of the library, such as "1.2.3". Compare it with `PUNCTUAL_VERSION`, that of the
 * header.
 */
const char *punctual_version(void);

/* --------------------------------------------------------------------------------------------------------------------
 * 2. Points, boxes and poses
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * A rotation followed by a translation: the 3 x 4 matrix `[R|t]`, row by row. `b_in_a` maps
 * coordinates of B to those of A: `((m[0]*x + m[1]*y) + m[2]*z) + m[3]` and so on, in double,
 * rounded after each operation.
 *
 * It is checked wherever it is used (finite, no entry of `|R^T R - I|` above 1e-3, no mirror)
 * and then used as it is.
 */
typedef struct punctual_pose {
  /**
   * Row by row; `m[3]`, `m[7]` and `m[11]` are the translation, in the length unit of the
   * meshes.
   */
  double m[12];
} punctual_pose;

/**
 * A point or a vector, in the length unit of the mesh.
 */
typedef struct punctual_point {
  /**
   * Along the x axis.
   */
  double x;
  /**
   * Along the y axis.
   */
  double y;
  /**
   * Along the z axis.
   */
  double z;
} punctual_point;

/**
 * A box that is parallel to the axes; empty if `min` exceeds `max`.
 */
typedef struct punctual_aabb {
  /**
   * Smallest coordinates.
   */
  struct punctual_point min;
  /**
   * Largest coordinates.
   */
  struct punctual_point max;
} punctual_aabb;

/**
 * The pose that maps every point to itself.
 */
struct punctual_pose punctual_pose_identity(void);

/**
 * A pose from a quaternion, which is normalised first, and a translation.
 *
 * Fails with BAD_POSE if the quaternion is zero or a number is not finite.
 */
punctual_status punctual_pose_from_quaternion(double x,
                                              double y,
                                              double z,
                                              double w,
                                              struct punctual_point translation,
                                              struct punctual_pose *pose);

/**
 * `outer` after `inner`, rounded: of `b_in_a` and `c_in_b`, `c_in_a`.
 *
 * Fails with BAD_POSE if one of them or the result is no pose.
 */
punctual_status punctual_pose_compose(struct punctual_pose outer,
                                      struct punctual_pose inner,
                                      struct punctual_pose *pose);

/**
 * The inverse map, rounded: of `b_in_a`, `a_in_b`.
 *
 * Fails with BAD_POSE if it or the result is no pose.
 */
punctual_status punctual_pose_inverse(struct punctual_pose of, struct punctual_pose *pose);

/* --------------------------------------------------------------------------------------------------------------------
 * 3. Meshes
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * A file format that can be read.
 */
enum punctual_format
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Wavefront OBJ: vertices and polygons.
   */
  PUNCTUAL_FORMAT_OBJ = 0,
  /**
   * STL, ASCII or binary.
   */
  PUNCTUAL_FORMAT_STL = 1,
  /**
   * PLY, ASCII or binary of both byte orders.
   */
  PUNCTUAL_FORMAT_PLY = 2,
  /**
   * glTF, binary or JSON text with its buffers in it: the triangles of the default scene,
   * moved by their nodes.
   */
  PUNCTUAL_FORMAT_GLTF = 3,
  /**
   * OFF in text.
   */
  PUNCTUAL_FORMAT_OFF = 4,
  /**
   * COLLADA: the meshes of the scene, moved by their nodes, in metres.
   */
  PUNCTUAL_FORMAT_COLLADA = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_format punctual_format;
#else
typedef uint32_t punctual_format;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A triangle surface: checked once when it is made, never changed after. Any number of threads may
 * read it.
 */
typedef struct punctual_mesh punctual_mesh;

/**
 * Numbers that describe a mesh.
 */
typedef struct punctual_mesh_facts {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Triangles.
   */
  size_t triangles;
  /**
   * Vertices, those that no triangle uses included.
   */
  size_t vertices;
  /**
   * Memory on the heap.
   */
  size_t bytes;
  /**
   * Whether the vertices are stored as float, which is then exact.
   */
  bool is_f32;
  /**
   * The smallest box around all vertices in use, in the frame of the mesh; empty without
   * triangles.
   */
  struct punctual_aabb bounds;
} punctual_mesh_facts;

/**
 * Makes a mesh from `3 * vertex_count` coordinates and `3 * triangle_count` vertex indices,
 * from 0, which are copied.
 *
 * Coordinates are in one length unit, the caller's, in the frame of the mesh, and kept to the
 * bit. Triangles may be degenerate, share vertices or overlap; vertices that none uses may
 * hold anything. No triangles are fine. Takes linear time.
 *
 * Fails with BAD_MESH if an index is out of range or a coordinate in use is not finite.
 */
punctual_status punctual_mesh_new_f32(const float *vertices,
                                      size_t vertex_count,
                                      const uint32_t *triangles,
                                      size_t triangle_count,
                                      struct punctual_mesh **mesh);

/**
 * Like `punctual_mesh_new_f32`. The mesh is stored as float if that keeps every bit of the
 * vertices in use.
 *
 * Fails with BAD_MESH also if a coordinate in use exceeds 2^1000.
 */
punctual_status punctual_mesh_new_f64(const double *vertices,
                                      size_t vertex_count,
                                      const uint32_t *triangles,
                                      size_t triangle_count,
                                      struct punctual_mesh **mesh);

/**
 * Reads the mesh of a file, OBJ, STL, PLY, OFF, glTF or COLLADA by its extension, also before
 * `.gz`. `path` is UTF-8 and ends with a zero byte.
 *
 * Polygons are triangulated; coordinates have the precision of the file. What is passed over
 * is not told; `punctual info` tells it. Takes time and memory in proportion to the file; a
 * glTF file may use its meshes for up to 2^24 triangles, and a packed file hold up to 2^30
 * bytes.
 *
 * Fails with BAD_FILE if the file cannot be read or holds no mesh, and with BAD_ARGUMENT if
 * `path` is not UTF-8. The text of `punctual_last_error` names the file and the line or byte
 * in it.
 */
punctual_status punctual_mesh_read(const char *path, struct punctual_mesh **mesh);

/**
 * Like `punctual_mesh_read` for the content of a file, of `count` bytes in a
 * `punctual_format`.
 *
 * Fails with BAD_FILE if it holds no mesh, and with BAD_ARGUMENT for an unknown format.
 */
punctual_status punctual_mesh_read_bytes(const uint8_t *bytes,
                                         size_t count,
                                         uint32_t format,
                                         struct punctual_mesh **mesh);

/**
 * Frees a mesh; null is fine. Trees have copies of their own.
 */
void punctual_mesh_free(struct punctual_mesh *mesh);

/**
 * Describes a mesh. Takes constant time.
 */
punctual_status punctual_mesh_describe(const struct punctual_mesh *mesh, struct punctual_mesh_facts *facts);

/**
 * The vertex indices of all triangles, three for each, in the order given. Valid as long as
 * the mesh.
 */
punctual_status punctual_mesh_indices(const struct punctual_mesh *mesh, const uint32_t **indices);

/**
 * One vertex, exact if a triangle uses it.
 *
 * Fails with BAD_ARGUMENT if there is no such vertex.
 */
punctual_status punctual_mesh_vertex(const struct punctual_mesh *mesh, size_t index, struct punctual_point *vertex);

/**
 * A sphere of radius 1 around the origin, `20 * 4^subdivisions` triangles; at most 12
 * subdivisions. As for all shapes, arguments that are out of range are moved into it, and the
 * same arguments give the same mesh.
 */
punctual_status punctual_shape_icosphere(uint32_t subdivisions, struct punctual_mesh **mesh);

/**
 * A box around the origin of these half extents, 1e-6 to 1e6; each face is a grid of `cells`
 * by `cells` squares, 1 to 8192: `12 * cells^2` triangles.
 */
punctual_status punctual_shape_cuboid(float half_x,
                                      float half_y,
                                      float half_z,
                                      uint32_t cells,
                                      struct punctual_mesh **mesh);

/**
 * A torus around the z axis: a tube of radius `minor`, 0.01 to 0.99 times `major`, along a
 * circle of radius `major`, 1e-6 to 1e6; `2 * resolution * max(3, resolution / 2)` triangles,
 * `resolution` 3 to 16384.
 */
punctual_status punctual_shape_torus(float major, float minor, uint32_t resolution, struct punctual_mesh **mesh);

/**
 * A tube of radius `tube`, 0.01 to 0.3, along a knot that winds `p` times around the z axis
 * while it winds `q` times around the tube of a torus of radii 2/3 and 1/3; `2 * resolution *
 * max(3, resolution / 8)` triangles.
 */
punctual_status punctual_shape_torus_knot(uint32_t p,
                                          uint32_t q,
                                          float tube,
                                          uint32_t resolution,
                                          struct punctual_mesh **mesh);

/**
 * A spur gear of outer radius 1 and thickness 0.3 around the z axis, `32 * teeth *
 * resolution^2` triangles; `teeth` is 3 to 4096, `resolution` 1 to 64.
 */
punctual_status punctual_shape_gear(uint32_t teeth, uint32_t resolution, struct punctual_mesh **mesh);

/**
 * Hills over the square from -1 to 1 in x and y, an open surface of `2 * resolution^2`
 * triangles. Each seed has its own.
 */
punctual_status punctual_shape_height_field(uint32_t resolution, uint64_t seed, struct punctual_mesh **mesh);

/* --------------------------------------------------------------------------------------------------------------------
 * 4. Trees
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * How much time a build may take to make queries faster.
 */
enum punctual_effort
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * For meshes that change or are asked about only a few times.
   */
  PUNCTUAL_EFFORT_FAST = 0,
  /**
   * The default.
   */
  PUNCTUAL_EFFORT_NORMAL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_effort punctual_effort;
#else
typedef uint32_t punctual_effort;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a mesh bounds. Rooms, terrain and shells bound nothing.
 */
enum punctual_solid
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * A surface without an inside; the default.
   */
  PUNCTUAL_SOLID_NO = 0,
  /**
   * A solid, oriented as its triangles are.
   */
  PUNCTUAL_SOLID_KEEP = 1,
  /**
   * A solid of which parts that are inside out are reversed: the second and third corner of
   * their triangles change places.
   */
  PUNCTUAL_SOLID_FLIP = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_solid punctual_solid;
#else
typedef uint32_t punctual_solid;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The bounding volume tree of one mesh. Any number of threads may read it and query it, as
 * long as none refits or frees it.
 */
typedef struct punctual_tree punctual_tree;

/**
 * How a tree is built. Begin with `punctual_build_options_default()`.
 */
typedef struct punctual_build_options {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * A `punctual_effort`.
   */
  uint32_t effort;
  /**
   * Whether boxes may be turned to where they are smallest: 0 or not 0.
   */
  uint32_t frames;
  /**
   * Whether to keep the corners that may be the farthest along a direction: 0 or not 0. In a
   * scene, convex bodies that are close are then told apart by a plane, without a search,
   * until a refit. Takes a third to the whole of the build's time more.
   */
  uint32_t extremes;
  /**
   * Most threads to build in; more than one only for large meshes. The tree is the same, to
   * the bit.
   */
  size_t threads;
  /**
   * A `punctual_solid`: what the mesh bounds.
   */
  size_t solid;
} punctual_build_options;

/**
 * Numbers that describe a tree.
 */
typedef struct punctual_tree_facts {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * How much looser the boxes have become since the build, by refits: the SAH cost now over
   * that after the build, no unit. Queries take about its square root as long as in a new tree.
   */
  float degradation;
  /**
   * Triangles of the mesh.
   */
  size_t triangles;
  /**
   * Nodes, leaves included.
   */
  size_t nodes;
  /**
   * Nodes whose children are triangles.
   */
  size_t leaves;
  /**
   * Levels of nodes; 0 for an empty mesh.
   */
  size_t depth;
  /**
   * Memory on the heap, the mesh included.
   */
  size_t bytes;
  /**
   * A length that goes with the size of the mesh; default tolerances are stated in it.
   */
  double unit_length;
} punctual_tree_facts;

/**
 * Mass properties of a solid of density 1.
 */
typedef struct punctual_mass_properties {
  /**
   * In the mesh's unit of length cubed.
   */
  double volume;
  /**
   * The centre of mass, in the coordinates of the mesh.
   */
  struct punctual_point center;
  /**
   * The inertia tensor about the centre of mass, for the axes of the mesh: row by row; it is
   * symmetric.
   */
  double inertia[9];
} punctual_mass_properties;

/**
 * One level of a tree.
 */
typedef struct punctual_tree_level {
  /**
   * Nodes on it.
   */
  uint32_t nodes;
  /**
   * Mean alpha of their subtrees per axis of their frames: the factor by which boxes shrink
   * on a binary level, 0 to 1.
   */
  float alpha[3];
  /**
   * Mean number of binary levels of their subtrees: log2 of their triangles.
   */
  float levels;
} punctual_tree_level;

/**
 * A pinhole camera of depth images. Rows go from top to bottom, and so does `y`; `x` goes to
 * the right and `z` forward.
 */
typedef struct punctual_depth_camera {
  /**
   * Pixels of a row.
   */
  size_t width;
  /**
   * Rows.
   */
  size_t height;
  /**
   * Focal lengths `fx`, `fy` in pixels; negative ones mirror.
   */
  double focal[2];
  /**
   * Where the axis of the camera passes, `cx`, `cy` in pixels: the centre of the first pixel
   * is at 0, 0.
   */
  double center[2];
  /**
   * The length of one unit of depth: 0.001 for millimetres and points in metres, 1 if both
   * are in one unit.
   */
  double scale;
} punctual_depth_camera;

/**
 * Frees a tree; null is fine. Scenes keep what they share.
 */
void punctual_tree_free(struct punctual_tree *tree);

/**
 * What `punctual_build_options_default` calls: writes as many bytes as the caller's struct has.
 */
void punctual_build_options_init(struct punctual_build_options *options, size_t size);

/**
 * Boxes that may be turned, normal effort, one thread.
 */
PUNCTUAL_INLINE punctual_build_options punctual_build_options_default(void) {
  punctual_build_options options;
  punctual_build_options_init(&options, sizeof options);
  return options;
}

/**
 * Builds the tree of a mesh, of which it keeps a copy. `options` may be null: the defaults.
 * Takes `n log n` time.
 *
 * Fails with BAD_ARGUMENT if `options->effort` or `options->solid` is unknown.
 */
punctual_status punctual_tree_new(const struct punctual_mesh *mesh,
                                  const struct punctual_build_options *options,
                                  struct punctual_tree **tree);

/**
 * The tree as bytes for `punctual_tree_from_bytes`, on any machine: as many as `capacity`
 * allows are written to `bytes`, and how many there are to `count`. They are the caller's. For
 * a closed mesh of floats they are about 30 a triangle. Takes linear time and allocates; with
 * a capacity of 0, where `bytes` may be null, it only counts, and allocates nothing.
 */
punctual_status punctual_tree_to_bytes(const struct punctual_tree *tree,
                                       uint8_t *bytes,
                                       size_t capacity,
                                       size_t *count);

/**
 * The tree that `punctual_tree_to_bytes` was called on, of which the bytes are not needed any
 * more: its queries do the same, to the bit. Takes a part of the time of a build.
 *
 * Fails with BAD_FILE if the bytes are no tree, are of another version of the format, or were
 * changed, cut or extended. Whatever they are, it takes no memory out of proportion to their
 * number, and the tree that it makes gives true answers about the mesh that they hold.
 */
punctual_status punctual_tree_from_bytes(const uint8_t *bytes, size_t count, struct punctual_tree **tree);

/**
 * Moves the vertices of the mesh, which keeps its triangles: all of them, `3 * vertex_count`
 * coordinates in the order of the mesh. Queries stay exact. Takes linear time, a small part of
 * a build, and allocates nothing, unless a scene shares the tree: the scene then keeps the old
 * one (see `punctual_scene_refit_f32`). Stopped queries cannot be resumed afterwards.
 *
 * Fails with BAD_MESH if their number is another or a coordinate in use is not finite; the
 * tree is unchanged then.
 */
punctual_status punctual_tree_refit_f32(struct punctual_tree *tree, const float *vertices, size_t vertex_count);

/**
 * Like `punctual_tree_refit_f32`. Allocates only once, if the mesh was stored as float and
 * needs double now.
 */
punctual_status punctual_tree_refit_f64(struct punctual_tree *tree, const double *vertices, size_t vertex_count);

/**
 * A copy of the mesh of a tree, as it is now.
 */
punctual_status punctual_tree_mesh(const struct punctual_tree *tree, struct punctual_mesh **mesh);

/**
 * Describes a tree. Takes linear time and allocates.
 */
punctual_status punctual_tree_describe(const struct punctual_tree *tree, struct punctual_tree_facts *facts);

/**
 * Computes the mass properties of a closed solid (`punctual_build_options.solid`). Takes
 * linear time and allocates.
 *
 * Fails with BAD_MESH if the tree is no solid, has open edges, is inside out, or has no
 * volume.
 */
punctual_status punctual_tree_mass_properties(const struct punctual_tree *tree, struct punctual_mass_properties *mass);

/**
 * Checks that every triangle is in one leaf and inside every box above it. Takes linear time
 * and allocates.
 *
 * Fails with BAD_TREE if not, which no tree that was built here does.
 */
punctual_status punctual_tree_validate(const struct punctual_tree *tree);

/**
 * Describes the levels of a tree, the root's first. Takes linear time and allocates.
 * As many as `capacity` allows are written to `levels`,
 * and how many there are to `count`.
 */
punctual_status punctual_tree_levels(const struct punctual_tree *tree,
                                     struct punctual_tree_level *levels,
                                     size_t levels_size,
                                     size_t capacity,
                                     size_t *count);

/**
 * The alphas of all nodes of a tree, as stored at build and refit: the product over the three
 * axes, 0 to 1. The root's first, each node before those below it.
 * As many as `capacity` allows are written to `alphas`,
 * and how many there are to `count`.
 */
punctual_status punctual_tree_node_alphas(const struct punctual_tree *tree,
                                          float *alphas,
                                          size_t capacity,
                                          size_t *count);

/**
 * Builds the tree of a point cloud, of `3 * count` coordinates, or of equal balls of this
 * radius. It is asked as that of a mesh is; where answers name triangles, they name points.
 * Takes some .1 us a point.
 *
 * Fails with BAD_MESH if a coordinate is not finite; the text names the point as a vertex.
 * Fails with BAD_ARGUMENT if the radius is negative or not finite.
 */
punctual_status punctual_tree_from_points_f32(const float *points,
                                              size_t count,
                                              double radius,
                                              struct punctual_tree **tree);

/**
 * Like `punctual_tree_from_points_f32`.
 */
punctual_status punctual_tree_from_points_f64(const double *points,
                                              size_t count,
                                              double radius,
                                              struct punctual_tree **tree);

/**
 * Builds the cloud of a depth image of `count` depths, row by row: pixel `(i, j)` of depth `d`
 * is the point `(d (i - cx) / fx, d (j - cy) / fy, d)`, times the scale, in the frame of the
 * camera. Pixels without a depth, 0, negative, infinite or NaN, are passed over, so the ids of
 * points are not those of pixels. `radius` is as of `punctual_tree_from_points_f32`.
 *
 * Fails with BAD_ARGUMENT if a number of the camera is not finite, a focal length is 0 or the
 * scale not above 0, there are more or fewer depths than pixels, or for the radius.
 */
punctual_status punctual_tree_from_depth(struct punctual_depth_camera camera,
                                         const float *depths,
                                         size_t count,
                                         double radius,
                                         struct punctual_tree **tree);

/**
 * A copy of a tree, thickened by a ball of this radius: all questions are about the points no
 * farther than that from its triangles, or points. It is in place of an earlier radius.
 *
 * Fails with BAD_ARGUMENT if the radius is negative or not finite.
 */
punctual_status punctual_tree_with_radius(const struct punctual_tree *tree,
                                          double radius,
                                          struct punctual_tree **thickened);

/**
 * A ball around the origin: a point with a radius. As of all shapes, lengths are 1e-150 to
 * 1e150; others fail with BAD_ARGUMENT, and the text names them.
 */
punctual_status punctual_tree_ball(double radius, struct punctual_tree **tree);

/**
 * All points no farther than `radius` from a segment of this length along z, around the
 * origin. The length may be 0.
 */
punctual_status punctual_tree_capsule(double radius, double length, struct punctual_tree **tree);

/**
 * A solid box around the origin with these lengths, which are at least twice the radius of its
 * rounded edges. The radius may be 0.
 */
punctual_status punctual_tree_box(double x, double y, double z, double radius, struct punctual_tree **tree);

/**
 * A solid cylinder along z, around the origin: a prism of 128 sides, which holds the true one
 * and is within 3.02e-4 of the radius of it.
 */
punctual_status punctual_tree_cylinder(double radius, double length, struct punctual_tree **tree);

/**
 * A solid cone along z: its base is at `-length / 2`, its tip at `length / 2`. A pyramid of
 * 128 sides, as a cylinder is a prism.
 */
punctual_status punctual_tree_cone(double radius, double length, struct punctual_tree **tree);

/**
 * The convex hull of points, of `3 * count` coordinates: a solid; exact.
 *
 * Fails with BAD_MESH if a coordinate is not finite, or if the points lie in one plane.
 */
punctual_status punctual_tree_hull(const double *points, size_t count, struct punctual_tree **tree);

/**
 * The surface over a grid, which faces +z: `count` heights in `columns` columns, row by row.
 * Height `i` is that of vertex `i`, at `x = step_x * (i % columns)`, `y = step_y * (i /
 * columns)`.
 *
 * Fails with BAD_ARGUMENT unless there are two whole rows and columns or more, and with
 * BAD_MESH if a height is not finite.
 */
punctual_status punctual_tree_height_field(const double *heights,
                                           size_t count,
                                           size_t columns,
                                           double step_x,
                                           double step_y,
                                           struct punctual_tree **tree);

/* --------------------------------------------------------------------------------------------------------------------
 * 5. Two triangles
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * Three corners, each x, y, z.
 */
typedef struct punctual_triangle {
  /**
   * Corner by corner.
   */
  double corners[3][3];
} punctual_triangle;

/**
 * Two points and what is between them.
 */
typedef struct punctual_segment {
  /**
   * One end.
   */
  struct punctual_point from;
  /**
   * The other one.
   */
  struct punctual_point to;
} punctual_segment;

/**
 * Whether two closed triangles share at least one point, exactly for the given coordinates.
 * Touching is intersecting; a degenerate triangle is the segment or point that it is.
 *
 * Fails with BAD_ARGUMENT if a coordinate is not finite or exceeds 2^1000.
 */
punctual_status punctual_triangles_intersect(struct punctual_triangle a, struct punctual_triangle b, bool *intersect);

/**
 * The segment in which two closed triangles meet. `meet` says whether they do; if not,
 * `segment`, two points, is left alone. Of triangles that touch in a point both ends are that
 * point; of triangles in one plane it is the longest segment in both. Ends are within 1e-12
 * times the largest coordinate of both triangles.
 *
 * Fails with BAD_ARGUMENT if a coordinate is not finite or exceeds 2^1000.
 */
punctual_status punctual_triangle_segment(struct punctual_triangle a,
                                          struct punctual_triangle b,
                                          struct punctual_segment *segment,
                                          bool *meet);

/* --------------------------------------------------------------------------------------------------------------------
 * 6. Budgets and clocks
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * The most work of an intersection query between two looks at a work budget, which can be overrun
 * by no more; the default poll interval.
 */
#define PUNCTUAL_MAX_STEP_WORK 352

/**
 * What PUNCTUAL_MAX_STEP_WORK is for intersection queries, for those of distances, contacts,
 * manifolds and motions.
 */
#define PUNCTUAL_MAX_DISTANCE_STEP_WORK 1040

/**
 * What `limit` of a budget limits.
 */
enum punctual_budget_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Nothing.
   */
  PUNCTUAL_BUDGET_KIND_UNLIMITED = 0,
  /**
   * Time from the start of the call, in nanoseconds.
   */
  PUNCTUAL_BUDGET_KIND_TIME = 1,
  /**
   * Units of work: where it stops depends on the input alone.
   */
  PUNCTUAL_BUDGET_KIND_WORK = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_budget_kind punctual_budget_kind;
#else
typedef uint32_t punctual_budget_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What one call may spend. Made by `punctual_budget_unlimited`, `punctual_budget_time` and
 * `punctual_budget_work`.
 */
typedef struct punctual_budget {
  /**
   * Nanoseconds or units of work.
   */
  uint64_t limit;
  /**
   * A `punctual_budget_kind`.
   */
  uint32_t kind;
  /**
   * Least work between looks at the clock, which bounds how late a time budget can end;
   * PUNCTUAL_MAX_STEP_WORK by default. A frame of a scene goes by the default.
   */
  uint64_t poll_interval;
} punctual_budget;

/**
 * A clock of the caller's. It is asked during the call that it is passed to, on the same
 * thread. It must not unwind (throw), and not use what that call is using.
 */
typedef struct punctual_clock {
  /**
   * Nanoseconds since some fixed moment, never less than before. `context` is the one below.
   */
  uint64_t (*now)(void *context);
  /**
   * Passed on to `now`.
   */
  void *context;
} punctual_clock;

/**
 * As much as it takes.
 */
struct punctual_budget punctual_budget_unlimited(void);

/**
 * Stop within this time from the start of the call.
 */
struct punctual_budget punctual_budget_time(uint64_t nanoseconds);

/**
 * Stop after this much work, at most PUNCTUAL_MAX_STEP_WORK later (distance queries:
 * PUNCTUAL_MAX_DISTANCE_STEP_WORK): the same bits on every machine, in every run.
 */
struct punctual_budget punctual_budget_work(uint64_t units);

/* --------------------------------------------------------------------------------------------------------------------
 * 7. Workspaces, and memory from frame to frame
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * Memory of one pair of trees between frames. It changes the speed of an answer, never the
 * answer; handed to another pair of trees, it forgets everything; refitted trees it takes for
 * the same. One thread at a time may use it.
 */
typedef struct punctual_memory punctual_memory;

/**
 * Every buffer that a query needs, and what the last query found and left open. Allocated
 * once: queries do not allocate. One thread at a time may use it.
 */
typedef struct punctual_workspace punctual_workspace;

/**
 * Two triangles that intersect: ids of the input meshes, from 0.
 */
typedef struct punctual_triangle_pair {
  /**
   * Triangle of A.
   */
  uint32_t a;
  /**
   * Triangle of B.
   */
  uint32_t b;
} punctual_triangle_pair;

/**
 * What is remembered.
 */
typedef struct punctual_memory_facts {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * When it was last decided: 1 if the surfaces met, 0 if not; -1 if it never was.
   */
  int32_t last_verdict;
  /**
   * Frames since it was last decided.
   */
  uint32_t frames_undecided;
  /**
   * BV tests of the last query that ran to its end; -1 if none did.
   */
  int64_t last_bv_tests;
  /**
   * How often the verdict changes from one decided frame to the next, 0 to 1: a mean over
   * about the last 20.
   */
  double change_rate;
} punctual_memory_facts;

/**
 * What the steps of a query cost, in nanoseconds.
 */
typedef struct punctual_cost_model {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * One BV test.
   */
  double bv_test;
  /**
   * One triangle pair.
   */
  double triangle_test;
  /**
   * One node pair that is opened.
   */
  double box_update;
  /**
   * One query.
   */
  double setup;
} punctual_cost_model;

/**
 * Frees a memory; null is fine.
 */
void punctual_memory_free(struct punctual_memory *memory);

/**
 * Makes a memory that knows nothing, of about 1 kB.
 */
punctual_status punctual_memory_new(struct punctual_memory **memory);

/**
 * Tells what is remembered.
 */
punctual_status punctual_memory_describe(const struct punctual_memory *memory, struct punctual_memory_facts *facts);

/**
 * Proven: how far apart the surfaces are at least at this pose, in the unit of the meshes, as
 * far as distance queries with this memory have shown it of these trees: what they proved,
 * less the longest way of a point of B since then. 0 if nothing is known. Costs some 50
 * operations. While it is more than 0, a `punctual_query` with this memory answers
 * VERDICT_SEPARATED at once.
 *
 * Fails with NULL, BAD_POSE or POISONED.
 */
punctual_status punctual_memory_clearance(const struct punctual_memory *memory,
                                          const struct punctual_tree *a,
                                          const struct punctual_tree *b,
                                          struct punctual_pose b_in_a,
                                          double *clearance);

/**
 * Frees a workspace; null is fine.
 */
void punctual_workspace_free(struct punctual_workspace *workspace);

/**
 * Makes a workspace with room for 4,096 queued node pairs and 65,536 found pairs, about 960
 * kB.
 */
punctual_status punctual_workspace_new(struct punctual_workspace **workspace);

/**
 * Makes a workspace with room for `queue` node pairs (a full queue costs order, no answer) and
 * `pairs` found pairs, at least 1 (when they are full, the query stops with PAIRS_FULL, to be
 * drained and resumed): `20 queue + 8 pairs` bytes and about 320 kB.
 *
 * Fails with OUT_OF_MEMORY if there is not that much.
 */
punctual_status punctual_workspace_with_capacity(size_t queue, size_t pairs, struct punctual_workspace **workspace);

/**
 * Uses the portable kernels from now on, whatever the machine offers: slower, the same bits.
 */
punctual_status punctual_workspace_use_portable_kernels(struct punctual_workspace *workspace);

/**
 * The intersecting pairs that the last query found, in order of discovery, without those
 * drained. They stay the workspace's, and are valid until it is used again.
 */
punctual_status punctual_workspace_pairs(const struct punctual_workspace *workspace,
                                         const struct punctual_triangle_pair **pairs,
                                         size_t *count);

/**
 * Forgets the found pairs, so that a query that stopped with PAIRS_FULL can be resumed. Copy
 * them first.
 */
punctual_status punctual_workspace_drain_pairs(struct punctual_workspace *workspace);

/**
 * The costs by which queries in this workspace go now.
 */
punctual_status punctual_workspace_cost_model(const struct punctual_workspace *workspace,
                                              struct punctual_cost_model *costs);

/**
 * Lets queries in this workspace begin with these costs; they change with each query under a
 * time budget.
 *
 * Fails with BAD_ARGUMENT if one is not finite.
 */
punctual_status punctual_workspace_set_cost_model(struct punctual_workspace *workspace,
                                                  const struct punctual_cost_model *costs);

/* --------------------------------------------------------------------------------------------------------------------
 * 8. What answers have in common
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * Why a query returned.
 */
enum punctual_stop_reason
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Nothing is left to visit: the answer is complete.
   */
  PUNCTUAL_STOP_REASON_FINISHED = 0,
  /**
   * The first intersection was found, which is all that MODE_ANY asks for.
   */
  PUNCTUAL_STOP_REASON_FIRST_HIT = 1,
  /**
   * The time was up.
   */
  PUNCTUAL_STOP_REASON_DEADLINE = 2,
  /**
   * The work was spent.
   */
  PUNCTUAL_STOP_REASON_WORK_LIMIT = 3,
  /**
   * The pair buffer was full. Drain it and resume.
   */
  PUNCTUAL_STOP_REASON_PAIRS_FULL = 4,
  /**
   * The processor is set to take denormal numbers for zero (FTZ, DAZ), and coordinates or
   * the pose are so small, below about 2^-960, that this could make an answer false. Clear
   * the setting and resume.
   */
  PUNCTUAL_STOP_REASON_FLUSHED_TO_ZERO = 5,
  /**
   * The call was cancelled. No clock of this interface does that.
   */
  PUNCTUAL_STOP_REASON_CANCELLED = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_stop_reason punctual_stop_reason;
#else
typedef uint32_t punctual_stop_reason;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Whether the surfaces meet. Never a mere yes or no: a budget can end before the answer is
 * known.
 */
enum punctual_verdict
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The budget ended first. It says nothing about contact: do not treat it as separated.
   */
  PUNCTUAL_VERDICT_UNDECIDED = 0,
  /**
   * Proven: the witness triangles share a point.
   */
  PUNCTUAL_VERDICT_INTERSECTING = 1,
  /**
   * Proven: no triangle of A shares a point with one of B; of bodies with margins, nor comes
   * within them.
   */
  PUNCTUAL_VERDICT_SEPARATED = 2,
  /**
   * Proven: the witness triangles are no farther apart than the margins of both bodies
   * together. Said only of bodies of a scene of which one has a margin. Whether some
   * triangles share a point is not said.
   */
  PUNCTUAL_VERDICT_WITHIN = 3,
  /**
   * Proven: the surfaces do not meet, but one body is inside the other: A if the first
   * number of the witness is 0, B if it is 1. Said only of two solids of which the outer one
   * is closed. Of bodies of a scene with a margin, a measured distance or a motion, it says
   * only that a vertex of this body is inside the other: their surfaces may meet, too.
   */
  PUNCTUAL_VERDICT_CONTAINED = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_verdict punctual_verdict;
#else
typedef uint32_t punctual_verdict;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a query has done, resumed calls included.
 */
typedef struct punctual_stats {
  /**
   * Box overlap tests.
   */
  uint64_t bv_tests;
  /**
   * Triangle pairs tested.
   */
  uint64_t primitive_tests;
  /**
   * Those among them that needed exact arithmetic.
   */
  uint64_t exact_tests;
  /**
   * Units of work; one is about 0.3 ns.
   */
  uint64_t work;
  /**
   * Time of all calls together in nanoseconds; -1 if it was not measured, which it is only
   * under a time budget.
   */
  int64_t elapsed;
  /**
   * Most node pairs that waited in the queue at once.
   */
  uint32_t queue_peak;
} punctual_stats;

/**
 * Bounds below which a number stays with the given probability.
 */
typedef struct punctual_quantiles {
  /**
   * 10 %.
   */
  double p10;
  /**
   * The median.
   */
  double p50;
  /**
   * 90 %.
   */
  double p90;
} punctual_quantiles;

/**
 * What a query left open; of a distance query, what may be closer than its `high`.
 */
typedef struct punctual_certificate {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Open pairs, of nodes or triangles; 0 means that nothing was missed.
   */
  size_t open_pairs;
  /**
   * No more triangle pairs than this intersect (or are closer), those found included.
   */
  uint64_t upper_bound;
  /**
   * Every missed intersection lies in a box with no edge longer than this, in the length
   * unit of the meshes.
   */
  double largest_extent;
} punctual_certificate;

/* --------------------------------------------------------------------------------------------------------------------
 * 9. Intersection: do two surfaces meet?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * What a query looks for.
 */
enum punctual_mode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Whether there is an intersection: stops at the first.
   */
  PUNCTUAL_MODE_ANY = 0,
  /**
   * Every intersecting pair of triangles.
   */
  PUNCTUAL_MODE_ALL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_mode punctual_mode;
#else
typedef uint32_t punctual_mode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Which node pair is visited next. All orders give the same finished answer; they differ in
 * what is known when a budget ends.
 */
enum punctual_order
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Deepest relative penetration of the boxes first; the default, and best at finding
   * intersections early.
   */
  PUNCTUAL_ORDER_PENETRATION = 0,
  /**
   * Lowest product of the two alphas first.
   */
  PUNCTUAL_ORDER_LOW_ALPHA = 1,
  /**
   * Depth-first: no queue at all, the least overhead.
   */
  PUNCTUAL_ORDER_DEPTH_FIRST = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_order punctual_order;
#else
typedef uint32_t punctual_order;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a stopped query has still to do; all 0 of a finished one.
 */
typedef struct punctual_remaining {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Units of work.
   */
  struct punctual_quantiles work;
  /**
   * Nanoseconds, at the pace of the run so far; of runs without a budget of time, by the
   * costs of the workspace.
   */
  struct punctual_quantiles time;
  /**
   * Probability that the surfaces meet; NaN for questions other than `punctual_query`.
   */
  double probability;
} punctual_remaining;

/**
 * A question: two trees, a pose, and what can be chosen. Plain data, made by
 * `punctual_query_new`, one for each pose; it borrows the trees. To resume a query or to ask
 * for its certificate, all of it must be what it was.
 */
typedef struct punctual_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Tree A.
   */
  const struct punctual_tree *a;
  /**
   * Tree B; it may be the same.
   */
  const struct punctual_tree *b;
  /**
   * Brings coordinates of B into those of A.
   */
  struct punctual_pose b_in_a;
  /**
   * A `punctual_mode`; MODE_ANY by default.
   */
  uint32_t mode;
  /**
   * A `punctual_order`; ORDER_PENETRATION by default.
   */
  uint32_t order;
  /**
   * Stop with PAIRS_FULL when this many pairs are in the workspace; by default SIZE_MAX:
   * when it is full.
   */
  size_t pair_limit;
  /**
   * The share of poses with an intersection among those that are asked about, 0 to 1, which
   * shifts the probability of `punctual_query_estimate`; by default that of the poses for
   * which the model was fitted.
   */
  double prior;
} punctual_query;

/**
 * What a query, or the rest of one, is expected to take.
 */
typedef struct punctual_prediction {
  /**
   * BV tests.
   */
  struct punctual_quantiles bv_tests;
  /**
   * Triangle pairs tested.
   */
  struct punctual_quantiles triangle_tests;
  /**
   * Units of work.
   */
  struct punctual_quantiles work;
  /**
   * Time in nanoseconds: of an estimate by the costs of its workspace, before a query by
   * those of the machine of the authors.
   */
  struct punctual_quantiles time;
} punctual_prediction;

/**
 * What can be said of a stopped query. Not proven: only verdict and certificate are.
 */
typedef struct punctual_estimate {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * What the query has still to do.
   */
  struct punctual_prediction remaining;
  /**
   * Probability that the surfaces meet: 1 with a hit at hand, 0 if they are proven to be
   * apart.
   */
  double probability;
  /**
   * Expected share of the intersecting pairs that has been found, 0 to 1; for MODE_ANY, 1 as
   * soon as it is decided.
   */
  double recall;
} punctual_estimate;

/**
 * The answer of a query. The found pairs stay in the workspace: `punctual_workspace_pairs`.
 */
typedef struct punctual_outcome {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Whether the surfaces meet.
   */
  punctual_verdict verdict;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * If they meet, two triangles that do; else zeros.
   */
  struct punctual_triangle_pair witness;
  /**
   * Intersecting pairs found, resumed calls and drained pairs included; at most 1 for
   * MODE_ANY.
   */
  uint64_t found;
  /**
   * What it has done.
   */
  struct punctual_stats stats;
} punctual_outcome;

/**
 * The question where a surface intersects itself. Plain data, made by
 * `punctual_self_query_new`; it borrows the tree. To resume a query or to ask for its
 * certificate, all of it must be what it was.
 *
 * Triangles without a common corner count if they share a point; with one, if they share
 * another point; with a common edge, if they are coplanar and on the same side of it. Corners
 * are common if their positions are equal. A triangle that is there twice counts.
 */
typedef struct punctual_self_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * A `punctual_mode`; MODE_ALL by default.
   */
  uint32_t mode;
  /**
   * The tree.
   */
  const struct punctual_tree *tree;
  /**
   * Stop with PAIRS_FULL when this many pairs are in the workspace; by default SIZE_MAX:
   * when it is full.
   */
  size_t pair_limit;
} punctual_self_query;

/**
 * What this query will take, if nothing stops it, given what is remembered of the pair;
 * `memory` may be null. Takes about a microsecond and allocates nothing.
 */
punctual_status punctual_query_predict(const struct punctual_query *query,
                                       const struct punctual_memory *memory,
                                       struct punctual_prediction *prediction);

/**
 * What the last run of this query in the workspace leaves open, given what is remembered of
 * the pair; `memory` may be null. Costs as much as `punctual_query_remaining`. Allocates
 * nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
 */
punctual_status punctual_query_estimate(const struct punctual_query *query,
                                        const struct punctual_workspace *workspace,
                                        const struct punctual_memory *memory,
                                        struct punctual_estimate *estimate);

/**
 * What `punctual_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_query_init(struct punctual_query *query,
                         size_t size,
                         const struct punctual_tree *a,
                         const struct punctual_tree *b,
                         struct punctual_pose b_in_a);

/**
 * The question whether `a` and `b` intersect, with the default options. Checked when it is
 * run.
 */
PUNCTUAL_INLINE punctual_query punctual_query_new(const struct punctual_tree *a,
                                                  const struct punctual_tree *b,
                                                  struct punctual_pose b_in_a) {
  punctual_query query;
  punctual_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/**
 * Runs a query within a budget. It does not allocate, lock or panic. `memory` may be null.
 *
 * Under a time budget it returns at most one poll interval of work late, under a work
 * budget at most PUNCTUAL_MAX_STEP_WORK units later. What it finds stays in the workspace.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_query_run(const struct punctual_query *query,
                                   struct punctual_workspace *workspace,
                                   struct punctual_memory *memory,
                                   struct punctual_budget budget,
                                   const struct punctual_clock *clock,
                                   struct punctual_outcome *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * However it is cut into pieces by work budgets, the outcome at the end is that of one
 * uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_query_resume(const struct punctual_query *query,
                                      struct punctual_workspace *workspace,
                                      struct punctual_memory *memory,
                                      struct punctual_budget budget,
                                      const struct punctual_clock *clock,
                                      struct punctual_outcome *outcome);

/**
 * What the last run of this query in the workspace left open.
 * Takes time linear in the open pairs; allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_query_certificate(const struct punctual_query *query,
                                           const struct punctual_workspace *workspace,
                                           struct punctual_certificate *certificate);

/**
 * Boxes in A's frame, at most one for each open pair.
 * Every missed intersection has all its points in one of them.
 * As many as `capacity` allows are written to `boxes`, and how many there are to
 * `count`.
 *
 * Fails as the function for the certificate.
 */
punctual_status punctual_query_open_boxes(const struct punctual_query *query,
                                          const struct punctual_workspace *workspace,
                                          struct punctual_aabb *boxes,
                                          size_t capacity,
                                          size_t *count);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *It goes by what is remembered of the pair; `memory` may be
 * null, and learns from it when the query has ended.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_query_remaining(const struct punctual_query *query,
                                         const struct punctual_workspace *workspace,
                                         const struct punctual_memory *memory,
                                         struct punctual_remaining *remaining);

/**
 * What `punctual_self_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_self_query_init(struct punctual_self_query *query, size_t size, const struct punctual_tree *tree);

/**
 * The question for all pairs of triangles of a mesh that intersect. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_self_query punctual_self_query_new(const struct punctual_tree *tree) {
  punctual_self_query query;
  punctual_self_query_init(&query, sizeof query, tree);
  return query;
}

/**
 * Runs a query within a budget. It does not allocate, lock or panic. The pairs stay in the
 * workspace, each once, the lower triangle first.
 *
 * Under a time budget it returns at most one poll interval of work late, under a work
 * budget at most PUNCTUAL_MAX_STEP_WORK units later.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_self_query_run(const struct punctual_self_query *query,
                                        struct punctual_workspace *workspace,
                                        struct punctual_budget budget,
                                        const struct punctual_clock *clock,
                                        struct punctual_outcome *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * However it is cut into pieces by work budgets, the outcome at the end is that of one
 * uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_self_query_resume(const struct punctual_self_query *query,
                                           struct punctual_workspace *workspace,
                                           struct punctual_budget budget,
                                           const struct punctual_clock *clock,
                                           struct punctual_outcome *outcome);

/**
 * What the last run of this query in the workspace left open.
 * Takes time linear in the open pairs; allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_self_query_certificate(const struct punctual_self_query *query,
                                                const struct punctual_workspace *workspace,
                                                struct punctual_certificate *certificate);

/**
 * Boxes in A's frame, at most one for each open pair.
 * Every missed intersection has all its points in one of them.
 * As many as `capacity` allows are written to `boxes`, and how many there are to
 * `count`.
 *
 * Fails as the function for the certificate.
 */
punctual_status punctual_self_query_open_boxes(const struct punctual_self_query *query,
                                               const struct punctual_workspace *workspace,
                                               struct punctual_aabb *boxes,
                                               size_t capacity,
                                               size_t *count);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_self_query_remaining(const struct punctual_self_query *query,
                                              const struct punctual_workspace *workspace,
                                              struct punctual_remaining *remaining);

/* --------------------------------------------------------------------------------------------------------------------
 * 10. Distance: how far apart are they?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * Whether two surfaces are no farther apart than the `closer_than` of a query.
 */
enum punctual_closer
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Not known: the budget ended first, it was not asked, or the distance is the limit up to
   * the rounding of numbers as large as the meshes.
   */
  PUNCTUAL_CLOSER_UNDECIDED = 0,
  /**
   * Proven: they are no farther apart.
   */
  PUNCTUAL_CLOSER_YES = 1,
  /**
   * Proven: they are farther apart.
   */
  PUNCTUAL_CLOSER_NO = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_closer punctual_closer;
#else
typedef uint32_t punctual_closer;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The question how far apart two surfaces are: 0 if they meet. Plain data, made by
 * `punctual_distance_query_new`, one for each pose; it borrows the trees. To resume a query or
 * to ask for its certificate, all of it must be what it was. Lengths are in the unit of the
 * meshes.
 */
typedef struct punctual_distance_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Whether the query is done as soon as `high` is no more than `absolute_tolerance`, even
   * if it is open then whether the surfaces meet: 0 (the default) or not 0.
   */
  uint32_t leave_contact_open;
  /**
   * Tree A.
   */
  const struct punctual_tree *a;
  /**
   * Tree B; it may be the same.
   */
  const struct punctual_tree *b;
  /**
   * Brings coordinates of B into those of A.
   */
  struct punctual_pose b_in_a;
  /**
   * Done as soon as `high - low` is no more than this length; 0: as close as double can
   * tell. -1 by default, as any negative number: a millionth of half the longest extent of
   * the larger mesh, roughly. Whether the surfaces meet is decided with any tolerance,
   * unless `leave_contact_open`.
   */
  double absolute_tolerance;
  /**
   * Done also as soon as `high <= (1 + relative_tolerance) low`. 0 by default; with a
   * negative `absolute_tolerance` that is 1e-5 for meshes that are more than 64 times their
   * size apart.
   */
  double relative_tolerance;
  /**
   * By how much each surface is thickened, A's first: a point becomes a ball, a segment a
   * capsule. The distance is that of the thickened surfaces. 0 by default.
   */
  double margins[2];
  /**
   * Ask only whether the surfaces are no farther apart than this length: done as soon as
   * that is known, in a fraction of the time. Infinity by default: the distance itself is
   * asked for.
   */
  double closer_than;
} punctual_distance_query;

/**
 * The answer of a distance query, wherever it stopped: `low <= distance <= high`, in the
 * length unit of the meshes.
 */
typedef struct punctual_distance {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Proven: the surfaces are nowhere closer. Infinite if one of the meshes is empty.
   */
  double low;
  /**
   * Proven: the distance of the two points, but for rounding. 0 only if the surfaces meet;
   * infinite if nothing was found yet.
   */
  double high;
  /**
   * The answer to `closer_than`.
   */
  punctual_closer closer;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * Whether triangles were found at all; if not, they and the points are zeros.
   */
  bool has_nearest;
  /**
   * The closest triangles found.
   */
  struct punctual_triangle_pair nearest;
  /**
   * Their closest points, A's first, both in A's frame; moved towards each other by the
   * margins. If the triangles meet, both are one point, whatever the margins: the middle of
   * the segment in which the triangles do.
   */
  struct punctual_point points[2];
  /**
   * What it has done.
   */
  struct punctual_stats stats;
} punctual_distance;

/**
 * What can be said of a stopped distance query. Not proven: only the bounds and the
 * certificate are.
 */
typedef struct punctual_distance_estimate {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Units of work that the query has still to do.
   */
  struct punctual_quantiles remaining;
  /**
   * The distance: within what is proven, and infinite above where nothing was found yet.
   */
  struct punctual_quantiles distance;
} punctual_distance_estimate;

/**
 * What `punctual_distance_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_distance_query_init(struct punctual_distance_query *query,
                                  size_t size,
                                  const struct punctual_tree *a,
                                  const struct punctual_tree *b,
                                  struct punctual_pose b_in_a);

/**
 * The question how far apart `a` and `b` are, with the default options. Checked when it is
 * run.
 */
PUNCTUAL_INLINE punctual_distance_query punctual_distance_query_new(const struct punctual_tree *a,
                                                                    const struct punctual_tree *b,
                                                                    struct punctual_pose b_in_a) {
  punctual_distance_query query;
  punctual_distance_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/**
 * Runs a distance query within a budget. It does not allocate, lock or panic. `memory` may
 * be null: what it knows of the frame before makes the answer faster.
 *
 * Under a time budget it returns at most one poll interval of work late, under a work
 * budget at most PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_distance_query_run(const struct punctual_distance_query *query,
                                            struct punctual_workspace *workspace,
                                            struct punctual_memory *memory,
                                            struct punctual_budget budget,
                                            const struct punctual_clock *clock,
                                            struct punctual_distance *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * Its bounds are no worse than before; however it is cut into pieces by work budgets, the
 * outcome at the end is that of one uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_distance_query_resume(const struct punctual_distance_query *query,
                                               struct punctual_workspace *workspace,
                                               struct punctual_memory *memory,
                                               struct punctual_budget budget,
                                               const struct punctual_clock *clock,
                                               struct punctual_distance *outcome);

/**
 * Where the last run of this query in the workspace may have missed what is closer than
 * its `high` by more than the tolerance.
 * Takes time linear in the open pairs; allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_distance_query_certificate(const struct punctual_distance_query *query,
                                                    const struct punctual_workspace *workspace,
                                                    struct punctual_certificate *certificate);

/**
 * Boxes in A's frame, at most one for each open pair.
 * Two points that are closer than `high` by more than the tolerance have their middle in
 * one of them. They reach as far as `high` beyond the surfaces, and are infinite where
 * nothing was found yet.
 * As many as `capacity` allows are written to `boxes`, and how many there are to
 * `count`.
 *
 * Fails as the function for the certificate.
 */
punctual_status punctual_distance_query_open_boxes(const struct punctual_distance_query *query,
                                                   const struct punctual_workspace *workspace,
                                                   struct punctual_aabb *boxes,
                                                   size_t capacity,
                                                   size_t *count);

/**
 * Units of work that this query will take if nothing stops it, given what is
 * remembered of the pair; `memory` may be null. Takes constant time and allocates
 * nothing.
 * A rough guess: nine of ten queries are within a factor of 6.5 of the median.
 */
punctual_status punctual_distance_query_predict(const struct punctual_distance_query *query,
                                                const struct punctual_memory *memory,
                                                struct punctual_quantiles *work);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *It goes by what is remembered of the pair; `memory` may be
 * null, and learns from it when the query has ended.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_distance_query_remaining(const struct punctual_distance_query *query,
                                                  const struct punctual_workspace *workspace,
                                                  const struct punctual_memory *memory,
                                                  struct punctual_remaining *remaining);

/**
 * What the last run of this query in the workspace leaves open, given what is remembered of
 * the pair; `memory` may be null. Takes constant time and allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
 */
punctual_status punctual_distance_query_estimate(const struct punctual_distance_query *query,
                                                 const struct punctual_workspace *workspace,
                                                 const struct punctual_memory *memory,
                                                 struct punctual_distance_estimate *estimate);

/* --------------------------------------------------------------------------------------------------------------------
 * 11. Contacts: where do they touch?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * The question where two surfaces meet or come within a margin of each other. Plain data, made
 * by `punctual_contact_query_new`, one for each pose; it borrows the trees. To resume a query
 * or to ask for its certificate, all of it must be what it was.
 */
typedef struct punctual_contact_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Tree A.
   */
  const struct punctual_tree *a;
  /**
   * Tree B; it may be the same.
   */
  const struct punctual_tree *b;
  /**
   * Brings coordinates of B into those of A.
   */
  struct punctual_pose b_in_a;
  /**
   * Stop with PAIRS_FULL when this many contacts are in the workspace, at least 1; by
   * default when it is full.
   */
  size_t contact_limit;
  /**
   * Pairs of triangles this close are contacts, in the unit of the meshes; 0 by default:
   * they meet. With infinity all pairs are.
   */
  double margin;
} punctual_contact_query;

/**
 * The answer of a contact query. The contacts stay in the workspace:
 * `punctual_workspace_contacts`.
 */
typedef struct punctual_contacts {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Proven: every contact that was not found is at least this far apart. Infinite if the
   * query is finished: none is missing.
   */
  double low;
  /**
   * Contacts found, resumed calls and drained contacts included.
   */
  uint64_t found;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * What it has done.
   */
  struct punctual_stats stats;
} punctual_contacts;

/**
 * The unit normals of a triangle of A and of one of B by the right-hand rule, in A's frame:
 * which way the surfaces face.
 */
typedef struct punctual_face_normals {
  /**
   * That of the triangle of A; zeros if it has no area.
   */
  struct punctual_point a;
  /**
   * That of the triangle of B; zeros if it has no area.
   */
  struct punctual_point b;
} punctual_face_normals;

/**
 * A triangle of A and one of B that meet or are close to one another. All of it is in A's
 * frame, in the unit of the meshes.
 */
typedef struct punctual_contact {
  /**
   * The triangles.
   */
  struct punctual_triangle_pair triangles;
  /**
   * Their closest points, of A and of B. Of triangles that meet both are the middle of the
   * segment.
   */
  struct punctual_point points[2];
  /**
   * Unit vector from B to A: moved along it, A parts from B. Of triangles that are apart it
   * is the direction of least distance; of triangles that meet, that of the unit normal of
   * B's triangle less that of A's, both by the right-hand rule.
   */
  struct punctual_point normal;
  /**
   * How far apart they are, up to some roundings. 0 only if they meet.
   */
  double distance;
  /**
   * Whether they meet; if not, the segment is zeros.
   */
  bool has_segment;
  /**
   * Where they meet: its ends; the same twice if that is a point.
   */
  struct punctual_point segment[2];
} punctual_contact;

/**
 * The question for the contact manifolds of two solids: triangles are counterclockwise seen
 * from outside. Plain data, made by `punctual_manifold_query_init`, one for each pose; it
 * borrows the trees. To resume a query, all of it must be what it was.
 */
typedef struct punctual_manifold_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Tree A.
   */
  const struct punctual_tree *a;
  /**
   * Tree B; it may be the same.
   */
  const struct punctual_tree *b;
  /**
   * Brings coordinates of B into those of A.
   */
  struct punctual_pose b_in_a;
  /**
   * Solids apart have points of contact up to this distance, in the unit of the meshes; 0 by
   * default: overlaps alone.
   */
  double skin;
} punctual_manifold_query;

/**
 * The answer of a query for manifolds. Their points stay in the workspace:
 * `punctual_workspace_manifold_points`.
 */
typedef struct punctual_manifolds {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Whether the surfaces are known to intersect.
   */
  bool meets;
  /**
   * Proven: every contact that is missing is at least this far apart; 0 while overlaps may
   * be missing. Infinite if the query is finished.
   */
  double low;
  /**
   * Pairs of triangles within the skin that were reduced, resumed calls included.
   */
  uint64_t found;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * What it has done.
   */
  struct punctual_stats stats;
} punctual_manifolds;

/**
 * A point of a contact manifold. All of it is in A's frame, in the unit of the meshes.
 */
typedef struct punctual_manifold_point {
  /**
   * The id of the point: with a memory the same from frame to frame.
   */
  uint64_t id;
  /**
   * The id of its manifold.
   */
  uint64_t manifold;
  /**
   * The point on A and the point on B.
   */
  struct punctual_point points[2];
  /**
   * Unit vector from B to A; zeros in an overlap without a normal, as of a pin through a
   * plate.
   */
  struct punctual_point normal;
  /**
   * Signed distance along the normal: negative where the solids are sunk into each other.
   */
  double distance;
  /**
   * Whether the surfaces intersect in this manifold, 1 or 0.
   */
  uint32_t is_overlap;
  /**
   * Whether all of the manifold was looked at, 1 or 0; if not, its depth is a lower bound.
   */
  uint32_t is_whole;
  /**
   * The area of the manifold, seen along the normal.
   */
  double area;
  /**
   * The middle of the manifold.
   */
  struct punctual_point centroid;
} punctual_manifold_point;

/**
 * The question which points of a cloud are no farther from a surface than a distance, each
 * once. Plain data, made by `punctual_near_points_query_new`, one for each pose; it borrows
 * the trees. To resume a query or to ask for its certificate, all of it must be what it was.
 *
 * A solid is its surface: a point deep inside is not near it. The radii of both trees add to
 * the distance. Of points that double cannot tell from points within, some are found, too.
 */
typedef struct punctual_near_points_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * The cloud, as made by `punctual_tree_from_points_f32` or the like.
   */
  const struct punctual_tree *a;
  /**
   * The surface: of a mesh, a shape or another cloud.
   */
  const struct punctual_tree *b;
  /**
   * Brings coordinates of B into those of A.
   */
  struct punctual_pose b_in_a;
  /**
   * The distance, in the length unit of the meshes; 0 by default, infinity for all points.
   */
  double distance;
  /**
   * Stop with PAIRS_FULL when this many points are in the workspace; by default SIZE_MAX:
   * when it is full.
   */
  size_t point_limit;
} punctual_near_points_query;

/**
 * The answer. The points stay in the workspace: `punctual_workspace_near_points`.
 */
typedef struct punctual_near_points {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * Points found, resumed calls and drained points included.
   */
  uint64_t found;
  /**
   * What it has done.
   */
  struct punctual_stats stats;
} punctual_near_points;

/**
 * What `punctual_contact_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_contact_query_init(struct punctual_contact_query *query,
                                 size_t size,
                                 const struct punctual_tree *a,
                                 const struct punctual_tree *b,
                                 struct punctual_pose b_in_a);

/**
 * The question where `a` and `b` meet, with the default options. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_contact_query punctual_contact_query_new(const struct punctual_tree *a,
                                                                  const struct punctual_tree *b,
                                                                  struct punctual_pose b_in_a) {
  punctual_contact_query query;
  punctual_contact_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/**
 * Runs a contact query within a budget. The first one in a workspace makes room for 4,096
 * contacts, unless `punctual_workspace_reserve_contacts` has made some; later ones do not
 * allocate. It does not lock or panic.
 *
 * Under a time budget it returns at most one poll interval of work late, under a work
 * budget at most PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_contact_query_run(const struct punctual_contact_query *query,
                                           struct punctual_workspace *workspace,
                                           struct punctual_budget budget,
                                           const struct punctual_clock *clock,
                                           struct punctual_contacts *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * After PAIRS_FULL drain the contacts or make room first. However it is cut into pieces by
 * work budgets, all contacts together are those of one uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_contact_query_resume(const struct punctual_contact_query *query,
                                              struct punctual_workspace *workspace,
                                              struct punctual_budget budget,
                                              const struct punctual_clock *clock,
                                              struct punctual_contacts *outcome);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_contact_query_remaining(const struct punctual_contact_query *query,
                                                 const struct punctual_workspace *workspace,
                                                 struct punctual_remaining *remaining);

/**
 * Where the last run of this query in the workspace may have missed contacts.
 * Takes time linear in the open pairs; allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_contact_query_certificate(const struct punctual_contact_query *query,
                                                   const struct punctual_workspace *workspace,
                                                   struct punctual_certificate *certificate);

/**
 * Boxes in A's frame, at most one for each open pair.
 * Every missed contact has the middle of its closest points in one of them.
 * As many as `capacity` allows are written to `boxes`, and how many there are to
 * `count`.
 *
 * Fails as the function for the certificate.
 */
punctual_status punctual_contact_query_open_boxes(const struct punctual_contact_query *query,
                                                  const struct punctual_workspace *workspace,
                                                  struct punctual_aabb *boxes,
                                                  size_t capacity,
                                                  size_t *count);

/**
 * Forgets the contacts, so that a query that stopped with PAIRS_FULL can be resumed. Copy them
 * first.
 */
punctual_status punctual_workspace_drain_contacts(struct punctual_workspace *workspace);

/**
 * Makes room for at least so many contacts, 170 bytes each.
 *
 * Fails with OUT_OF_MEMORY if there is not that much.
 */
punctual_status punctual_workspace_reserve_contacts(struct punctual_workspace *workspace, size_t contacts);

/**
 * Tells which way the triangles of a contact face. The query need not have been run; only its
 * trees and its pose matter.
 *
 * Fails with BAD_ARGUMENT if one of the meshes has no such triangle.
 */
punctual_status punctual_contact_face_normals(const struct punctual_contact_query *query,
                                              struct punctual_triangle_pair triangles,
                                              struct punctual_face_normals *normals);

/**
 * The contacts that the last query found, if it was a contact query, without those drained:
 * the nearest first.
 * As many as `capacity` allows are written to `contacts`,
 * and how many there are to `count`.
 */
punctual_status punctual_workspace_contacts(const struct punctual_workspace *workspace,
                                            struct punctual_contact *contacts,
                                            size_t contacts_size,
                                            size_t capacity,
                                            size_t *count);

/**
 * What `punctual_manifold_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_manifold_query_init(struct punctual_manifold_query *query,
                                  size_t size,
                                  const struct punctual_tree *a,
                                  const struct punctual_tree *b,
                                  struct punctual_pose b_in_a);

/**
 * The question for the manifolds of `a` and `b`, without a skin. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_manifold_query punctual_manifold_query_new(const struct punctual_tree *a,
                                                                    const struct punctual_tree *b,
                                                                    struct punctual_pose b_in_a) {
  punctual_manifold_query query;
  punctual_manifold_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/**
 * Runs a query for manifolds within a budget. It keeps its buffers in the workspace, so it
 * allocates only where a query is larger than those before. It does not lock or panic.
 * `memory` may be null: it keeps the ids from frame to frame.
 *
 * If more pairs intersect than `punctual_workspace_reserve_contacts` has made room for,
 * 4,096 by default, it stops with PAIRS_FULL; make room and resume it.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_manifold_query_run(const struct punctual_manifold_query *query,
                                            struct punctual_workspace *workspace,
                                            struct punctual_memory *memory,
                                            struct punctual_budget budget,
                                            const struct punctual_clock *clock,
                                            struct punctual_manifolds *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * However it is cut into pieces by work budgets, the manifolds at the end are those of one
 * uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_manifold_query_resume(const struct punctual_manifold_query *query,
                                               struct punctual_workspace *workspace,
                                               struct punctual_memory *memory,
                                               struct punctual_budget budget,
                                               const struct punctual_clock *clock,
                                               struct punctual_manifolds *outcome);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *It goes by what is remembered of the pair; `memory` may be
 * null, and learns from it when the query has ended.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_manifold_query_remaining(const struct punctual_manifold_query *query,
                                                  const struct punctual_workspace *workspace,
                                                  const struct punctual_memory *memory,
                                                  struct punctual_remaining *remaining);

/**
 * The points of the manifolds that the last query found, if it was one for manifolds: those of
 * the deepest first.
 * As many as `capacity` allows are written to `points`,
 * and how many there are to `count`.
 */
punctual_status punctual_workspace_manifold_points(const struct punctual_workspace *workspace,
                                                   struct punctual_manifold_point *points,
                                                   size_t points_size,
                                                   size_t capacity,
                                                   size_t *count);

/**
 * What `punctual_near_points_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_near_points_query_init(struct punctual_near_points_query *query,
                                     size_t size,
                                     const struct punctual_tree *a,
                                     const struct punctual_tree *b,
                                     struct punctual_pose b_in_a);

/**
 * The question which points of the cloud `a` are on the surface of `b`, or within a distance
 * that is set after. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_near_points_query punctual_near_points_query_new(const struct punctual_tree *a,
                                                                          const struct punctual_tree *b,
                                                                          struct punctual_pose b_in_a) {
  punctual_near_points_query query;
  punctual_near_points_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/**
 * Finds the points within a budget. The first query in a workspace makes room for 4,096
 * points, unless `punctual_workspace_reserve_near_points` has made some, and for marks of
 * the cloud, 5 bytes for eight points; nothing else allocates. It does not lock or panic.
 *
 * Under a time budget it returns at most one poll interval of work late.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_near_points_query_run(const struct punctual_near_points_query *query,
                                               struct punctual_workspace *workspace,
                                               struct punctual_budget budget,
                                               const struct punctual_clock *clock,
                                               struct punctual_near_points *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * After PAIRS_FULL drain the points or make room first. However it is cut into pieces by
 * work budgets, the points at the end are those of one uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_near_points_query_resume(const struct punctual_near_points_query *query,
                                                  struct punctual_workspace *workspace,
                                                  struct punctual_budget budget,
                                                  const struct punctual_clock *clock,
                                                  struct punctual_near_points *outcome);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_near_points_query_remaining(const struct punctual_near_points_query *query,
                                                     const struct punctual_workspace *workspace,
                                                     struct punctual_remaining *remaining);

/**
 * Where the last run of this query in the workspace may have missed points.
 * Takes time linear in the open pairs; allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_near_points_query_certificate(const struct punctual_near_points_query *query,
                                                       const struct punctual_workspace *workspace,
                                                       struct punctual_certificate *certificate);

/**
 * Boxes in A's frame, at most one for each open pair.
 * The middle between a missed point and the surface is in one of them.
 * As many as `capacity` allows are written to `boxes`, and how many there are to
 * `count`.
 *
 * Fails as the function for the certificate.
 */
punctual_status punctual_near_points_query_open_boxes(const struct punctual_near_points_query *query,
                                                      const struct punctual_workspace *workspace,
                                                      struct punctual_aabb *boxes,
                                                      size_t capacity,
                                                      size_t *count);

/**
 * Forgets the points, so that a query that stopped with PAIRS_FULL can be resumed. Copy them
 * first.
 */
punctual_status punctual_workspace_drain_near_points(struct punctual_workspace *workspace);

/**
 * Makes room for at least so many points, 4 bytes each.
 *
 * Fails with OUT_OF_MEMORY if there is not that much.
 */
punctual_status punctual_workspace_reserve_near_points(struct punctual_workspace *workspace, size_t points);

/**
 * The points that the last query found, if it was for points near a surface, without those
 * drained: by their index in the input of the cloud, in order of discovery.
 * As many as `capacity` allows are written to `points`,
 * and how many there are to `count`.
 */
punctual_status punctual_workspace_near_points(const struct punctual_workspace *workspace,
                                               uint32_t *points,
                                               size_t capacity,
                                               size_t *count);

/* --------------------------------------------------------------------------------------------------------------------
 * 12. Motion: until when are they free?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * A rigid motion in one unit of time, from time 0 to 1: constant velocity, and constant turn
 * about an axis that moves along. At time `t` a point that `start` brings to `x` is at `p + t
 * velocity + R(t turn) (x - p)`, where `p` is a point of the axis at time 0. It is checked
 * wherever it is used.
 */
typedef struct punctual_motion {
  /**
   * Where it begins.
   */
  struct punctual_pose start;
  /**
   * The velocity of the axis: length per unit of time.
   */
  struct punctual_point velocity;
  /**
   * The axis by the right-hand rule, times the angle in radians; zeros: no turn.
   */
  struct punctual_point turn;
  /**
   * From a point of the axis to the origin of the body at time 0; zeros: the axis goes
   * through it.
   */
  struct punctual_point arm;
} punctual_motion;

/**
 * The question until when a motion is free, and when the surfaces meet. Plain data, made by
 * `punctual_motion_query_new`, one for each motion; it borrows the trees. To resume a query
 * all of it must be what it was. Lengths are in the unit of the meshes, times from 0 to 1.
 */
typedef struct punctual_motion_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Whether A moves too: 0 (the default) or not 0.
   */
  uint32_t a_moves;
  /**
   * Tree A.
   */
  const struct punctual_tree *a;
  /**
   * Tree B; it may be the same.
   */
  const struct punctual_tree *b;
  /**
   * How B moves: in A's frame, or in the world if A moves too.
   */
  struct punctual_motion of_b;
  /**
   * How, in the world.
   */
  struct punctual_motion of_a;
  /**
   * Done when nothing moves farther than this, seen from A, between the two times; 0: as
   * close as double can tell. -1 by default, as any negative number: a millionth of the
   * longest extent of the smaller mesh, roughly.
   */
  double tolerance;
  /**
   * Done also when the two times differ by no more than this. 0 by default.
   */
  double time_tolerance;
  /**
   * By how much each surface is thickened, A's first. 0 by default.
   */
  double margins[2];
} punctual_motion_query;

/**
 * The answer of a motion query, wherever it stopped; times from 0 to 1.
 */
typedef struct punctual_passage {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Proven: the surfaces meet at no time before. 1 without a contact: the motion is free to
   * its end.
   */
  double free_until;
  /**
   * Whether a contact was found (yet); if not, its time and the triangles are zeros.
   */
  bool touches;
  /**
   * Proven: the surfaces meet at this time; 0 if they do at the start.
   */
  double touching_at;
  /**
   * The triangles that meet then.
   */
  struct punctual_triangle_pair triangles;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * What it has done.
   */
  struct punctual_stats stats;
} punctual_passage;

/**
 * A straight line without turn.
 */
struct punctual_motion punctual_motion_straight(struct punctual_pose start, struct punctual_point velocity);

/**
 * Runs a motion query within a budget. It does not allocate, lock or panic. `memory` may
 * be null: what it knows of the motion before makes the answer faster.
 *
 * Under a time budget it returns at most one poll interval of work late, under a work
 * budget at most PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_motion_query_run(const struct punctual_motion_query *query,
                                          struct punctual_workspace *workspace,
                                          struct punctual_memory *memory,
                                          struct punctual_budget budget,
                                          const struct punctual_clock *clock,
                                          struct punctual_passage *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * However it is cut into pieces by work budgets, the outcome at the end is that of one
 * uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_motion_query_resume(const struct punctual_motion_query *query,
                                             struct punctual_workspace *workspace,
                                             struct punctual_memory *memory,
                                             struct punctual_budget budget,
                                             const struct punctual_clock *clock,
                                             struct punctual_passage *outcome);

/**
 * Units of work that this query will take if nothing stops it, given what is
 * remembered of the pair; `memory` may be null. Takes constant time and allocates
 * nothing.
 * A rough guess: nine of ten queries are within a factor of 8.6 of the median.
 */
punctual_status punctual_motion_query_predict(const struct punctual_motion_query *query,
                                              const struct punctual_memory *memory,
                                              struct punctual_quantiles *work);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *It goes by what is remembered of the pair; `memory` may be
 * null, and learns from it when the query has ended.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_motion_query_remaining(const struct punctual_motion_query *query,
                                                const struct punctual_workspace *workspace,
                                                const struct punctual_memory *memory,
                                                struct punctual_remaining *remaining);

/**
 * Where the surfaces may still meet before the contact that the last run of this query in
 * the workspace found, if any.
 * Takes time linear in the open pairs; allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_motion_query_certificate(const struct punctual_motion_query *query,
                                                  const struct punctual_workspace *workspace,
                                                  struct punctual_certificate *certificate);

/**
 * Boxes in A's frame, at most one for each open pair.
 * Where the surfaces meet before the contact that was found, if any, all points of A that
 * B touches are in one of them.
 * As many as `capacity` allows are written to `boxes`, and how many there are to
 * `count`.
 *
 * Fails as the function for the certificate.
 */
punctual_status punctual_motion_query_open_boxes(const struct punctual_motion_query *query,
                                                 const struct punctual_workspace *workspace,
                                                 struct punctual_aabb *boxes,
                                                 size_t capacity,
                                                 size_t *count);

/**
 * The screw from one pose to another: a turn of at most half a circle about an axis, and a
 * shift along it.
 *
 * Fails with BAD_POSE or BAD_ARGUMENT.
 */
punctual_status punctual_motion_screw(struct punctual_pose start,
                                      struct punctual_pose end,
                                      struct punctual_motion *motion);

/**
 * Where the body is at a time, 0 to 1; times outside are taken for 0 or 1, and NaN for 0.
 *
 * Fails with BAD_POSE or BAD_ARGUMENT.
 */
punctual_status punctual_motion_pose(const struct punctual_motion *motion, double time, struct punctual_pose *pose);

/**
 * What `punctual_motion_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_motion_query_init(struct punctual_motion_query *query,
                                size_t size,
                                const struct punctual_tree *a,
                                const struct punctual_tree *b,
                                struct punctual_motion b_in_a);

/**
 * The question until when the motion of `b` in the frame of `a` is free, with the default
 * options. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_motion_query punctual_motion_query_new(const struct punctual_tree *a,
                                                                const struct punctual_tree *b,
                                                                struct punctual_motion b_in_a) {
  punctual_motion_query query;
  punctual_motion_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/* --------------------------------------------------------------------------------------------------------------------
 * 13. Penetration: how deep are they, and what parts them?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * Whether two bodies penetrate each other deeper than the `deeper_than` of a query.
 */
enum punctual_deeper
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Not known: the budget ended first, it was not asked, or the depth is the limit up to the
   * rounding of numbers as large as the meshes.
   */
  PUNCTUAL_DEEPER_UNDECIDED = 0,
  /**
   * Proven: no translation that is as short as the limit parts them.
   */
  PUNCTUAL_DEEPER_YES = 1,
  /**
   * Proven: a translation no longer than the limit parts them.
   */
  PUNCTUAL_DEEPER_NO = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_deeper punctual_deeper;
#else
typedef uint32_t punctual_deeper;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Every buffer that a penetration query needs, about 2 MB, and what the last one left open.
 * Allocated once: queries do not allocate. One thread at a time may use it.
 */
typedef struct punctual_penetration_workspace punctual_penetration_workspace;

/**
 * The question how far B has to be moved, at least, until the bodies are apart. Plain data,
 * made by `punctual_penetration_query_new`, one for each pose; it borrows the trees. To resume
 * a query, all of it must be what it was.
 */
typedef struct punctual_penetration_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Whether closed components of trees that were built as solids are solids: 0 or not 0.
   * Then a body inside of the other penetrates it. 0 by default.
   */
  uint16_t solid;
  /**
   * Whether only a short push is looked for, so that low stays 0: 0 or not 0. The query is
   * then finished when it has tried 32 directions all around and turned the best one. 0 by
   * default.
   */
  uint16_t push_only;
  /**
   * Tree A.
   */
  const struct punctual_tree *a;
  /**
   * Tree B; it may be the same.
   */
  const struct punctual_tree *b;
  /**
   * Brings coordinates of B into those of A.
   */
  struct punctual_pose b_in_a;
  /**
   * Finished as soon as high <= (1 + this) low; 0.001 by default. Negative values and NaN
   * count as 0.
   */
  double relative_tolerance;
  /**
   * Finished as soon as high <= low + this, too; 0 by default. Negative values and NaN count
   * as 0.
   */
  double absolute_tolerance;
  /**
   * Finished as soon as it is known whether the bodies penetrate each other deeper than
   * this, whatever the tolerances; infinite by default, which asks nothing. Negative values
   * and NaN count as 0.
   */
  double deeper_than;
} punctual_penetration_query;

/**
 * The answer: low <= depth <= high, both proven, also where a budget ended the query. Lengths
 * are in the unit of the meshes.
 */
typedef struct punctual_penetration {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Whether a push is known; if not, the bodies are apart, or the budget ended before one
   * was found, and the direction is zeros.
   */
  bool has_push;
  /**
   * Where B moves to, a unit vector in A's frame.
   */
  struct punctual_point direction;
  /**
   * No shorter translation of B parts the bodies.
   */
  double low;
  /**
   * The length of the push; 0 if they are apart, infinite if none is known.
   */
  double high;
  /**
   * The pose after the push, at which they are apart: proven. The pose of the query if no
   * push is known.
   */
  struct punctual_pose b_in_a;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * The answer to `deeper_than`.
   */
  punctual_deeper deeper;
  /**
   * Units of work, resumed calls included.
   */
  uint64_t work;
  /**
   * Time in nanoseconds, resumed calls included; -1 if it was not measured, which it is only
   * under a time budget.
   */
  int64_t elapsed;
} punctual_penetration;

/**
 * Frees a workspace; null is fine.
 */
void punctual_penetration_workspace_free(struct punctual_penetration_workspace *workspace);

/**
 * Makes a workspace.
 */
punctual_status punctual_penetration_workspace_new(struct punctual_penetration_workspace **workspace);

/**
 * What `punctual_penetration_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_penetration_query_init(struct punctual_penetration_query *query,
                                     size_t size,
                                     const struct punctual_tree *a,
                                     const struct punctual_tree *b,
                                     struct punctual_pose b_in_a);

/**
 * The question how deep `a` and `b` penetrate each other, with the default options. Checked
 * when it is run.
 */
PUNCTUAL_INLINE punctual_penetration_query punctual_penetration_query_new(const struct punctual_tree *a,
                                                                          const struct punctual_tree *b,
                                                                          struct punctual_pose b_in_a) {
  punctual_penetration_query query;
  punctual_penetration_query_init(&query, sizeof query, a, b, b_in_a);
  return query;
}

/**
 * Bounds the depth within a budget. It does not allocate, lock or panic.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_penetration_query_run(const struct punctual_penetration_query *query,
                                               struct punctual_penetration_workspace *workspace,
                                               struct punctual_budget budget,
                                               const struct punctual_clock *clock,
                                               struct punctual_penetration *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_penetration_query_resume(const struct punctual_penetration_query *query,
                                                  struct punctual_penetration_workspace *workspace,
                                                  struct punctual_budget budget,
                                                  const struct punctual_clock *clock,
                                                  struct punctual_penetration *outcome);

/* --------------------------------------------------------------------------------------------------------------------
 * 14. Rays: what do they hit?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * The triangle of a ray that hits none.
 */
#define PUNCTUAL_NO_TRIANGLE 4294967295

/**
 * The side of a triangle that a ray comes from.
 */
enum punctual_side
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The one from which the corners appear counterclockwise.
   */
  PUNCTUAL_SIDE_FRONT = 0,
  /**
   * The other one.
   */
  PUNCTUAL_SIDE_BACK = 1,
  /**
   * None: the ray lies in the triangle's plane, or the triangle is a segment or a point.
   */
  PUNCTUAL_SIDE_EDGE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_side punctual_side;
#else
typedef uint32_t punctual_side;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Which of its hits a ray is asked for.
 */
enum punctual_ray_mode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The one with the least `t`; of several with the same, the triangle with the least id.
   */
  PUNCTUAL_RAY_MODE_NEAREST = 0,
  /**
   * Any: whether there is one. Stops at the first that is found.
   */
  PUNCTUAL_RAY_MODE_ANY = 1,
  /**
   * All, each triangle once; not for batches.
   */
  PUNCTUAL_RAY_MODE_ALL = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_ray_mode punctual_ray_mode;
#else
typedef uint32_t punctual_ray_mode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A half-line from an origin in a direction of any length, or a segment between two points, in
 * the frame of the mesh. Plain data, made by `punctual_ray_new` or `punctual_ray_segment`;
 * checked wherever it is used, and then used as it is.
 */
typedef struct punctual_ray {
  /**
   * Where it begins.
   */
  struct punctual_point origin;
  /**
   * Its direction, not zero; of a segment, its end.
   */
  struct punctual_point target;
  /**
   * Hits before this parameter are left out. 0 by default.
   */
  double t_min;
  /**
   * Hits after this parameter are left out. Infinity by default. To end exactly at a point,
   * take a segment.
   */
  double t_max;
  /**
   * 0: a half-line; else a segment, of which `t` goes from 0 to 1.
   */
  uint32_t is_segment;
} punctual_ray;

/**
 * The question what a ray hits. Plain data, made by `punctual_ray_query_new`, one for each
 * ray; it borrows the tree. To resume a query all of it must be what it was.
 *
 * A triangle is hit if it shares a point with the ray, exactly for the coordinates as they are
 * given: closed triangles, edges and corners included.
 */
typedef struct punctual_ray_query {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * A `punctual_ray_mode`; RAY_MODE_NEAREST by default.
   */
  uint32_t mode;
  /**
   * The tree.
   */
  const struct punctual_tree *tree;
  /**
   * The ray.
   */
  struct punctual_ray ray;
  /**
   * Not 0: ask whether the ray starts inside the solid, too. 0 by default.
   */
  uint64_t solid;
} punctual_ray_query;

/**
 * A triangle that a ray meets.
 */
typedef struct punctual_ray_hit {
  /**
   * Id of the input mesh, or PUNCTUAL_NO_TRIANGLE.
   */
  uint32_t triangle;
  /**
   * The side that the ray comes from; SIDE_FRONT without a hit.
   */
  punctual_side side;
  /**
   * The least parameter of a common point, which is `origin + t direction`, of a segment
   * `origin + t (end - origin)`. Off by at most 1e-11 of the largest coordinate of the
   * triangle seen from the origin, over the largest component of the direction. Infinite
   * without a hit.
   */
  double t;
} punctual_ray_hit;

/**
 * The answer of a ray query, wherever it stopped. All hits stay in the workspace:
 * `punctual_workspace_ray_hits`.
 */
typedef struct punctual_ray_cast {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * The nearest hit of those found; for RAY_MODE_ANY the one found.
   */
  struct punctual_ray_hit hit;
  /**
   * Hits found, resumed calls and drained hits included; for RAY_MODE_NEAREST those that
   * were compared.
   */
  uint64_t found;
  /**
   * Proven: every hit that was not found is at this parameter or after it. For
   * RAY_MODE_NEAREST never after the hit that was found. Infinite if there is none.
   */
  double free_until;
  /**
   * Why the query returned.
   */
  punctual_stop_reason stop;
  /**
   * What it has done.
   */
  struct punctual_stats stats;
  /**
   * A `punctual_inside`: whether the ray starts inside the solid or on its surface;
   * INSIDE_UNDECIDED if that was not asked, the tree was not built as a solid, or the budget
   * ended first.
   */
  uint64_t starts_inside;
} punctual_ray_cast;

/**
 * The question what each of many rays hits, answered one after the other within one budget, in
 * less time than a query for each. Plain data, made by `punctual_ray_batch_new`; it borrows
 * the tree and the rays. To resume it all of it, and the rays, must be what they were.
 */
typedef struct punctual_ray_batch {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * RAY_MODE_NEAREST, by default, or RAY_MODE_ANY.
   */
  uint32_t mode;
  /**
   * The tree.
   */
  const struct punctual_tree *tree;
  /**
   * The rays.
   */
  const struct punctual_ray *rays;
  /**
   * How many.
   */
  size_t count;
} punctual_ray_batch;

/**
 * The answer for many rays; their hits are in the caller's array.
 */
typedef struct punctual_ray_batch_outcome {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * The first so many rays are done and their hits are written.
   */
  size_t done;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * What it has done for all rays.
   */
  struct punctual_stats stats;
} punctual_ray_batch_outcome;

/**
 * The half-line from a point in a direction. Checked when it is used.
 */
struct punctual_ray punctual_ray_new(struct punctual_point origin, struct punctual_point direction);

/**
 * The segment between two points, both of them included. Checked when it is used.
 */
struct punctual_ray punctual_ray_segment(struct punctual_point from, struct punctual_point to);

/**
 * What `punctual_ray_query_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_ray_query_init(struct punctual_ray_query *query,
                             size_t size,
                             const struct punctual_tree *tree,
                             struct punctual_ray ray);

/**
 * The question for the nearest hit of a ray. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_ray_query punctual_ray_query_new(const struct punctual_tree *tree, struct punctual_ray ray) {
  punctual_ray_query query;
  punctual_ray_query_init(&query, sizeof query, tree, ray);
  return query;
}

/**
 * Runs a ray query within a budget. The first one for all hits in a workspace makes room
 * for 4,096 hits, unless `punctual_workspace_reserve_ray_hits` has made some; nothing else
 * allocates. It does not lock or panic.
 *
 * Under a time budget it returns at most one poll interval of work late, under a work
 * budget at most PUNCTUAL_MAX_STEP_WORK units later.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
 * workspace is unchanged then.
 */
punctual_status punctual_ray_query_run(const struct punctual_ray_query *query,
                                       struct punctual_workspace *workspace,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_ray_cast *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget.
 * After PAIRS_FULL drain the hits or make room first. However it is cut into pieces by
 * work budgets, the outcome at the end is that of one uninterrupted run.
 *
 * Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
 * this very query or is complete.
 */
punctual_status punctual_ray_query_resume(const struct punctual_ray_query *query,
                                          struct punctual_workspace *workspace,
                                          struct punctual_budget budget,
                                          const struct punctual_clock *clock,
                                          struct punctual_ray_cast *outcome);

/**
 * What the last run of this query in the workspace has still to do. docs/c.md states
 * the cost. Allocates nothing.
 *
 * Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
 * query.
 */
punctual_status punctual_ray_query_remaining(const struct punctual_ray_query *query,
                                             const struct punctual_workspace *workspace,
                                             struct punctual_remaining *remaining);

/**
 * Forgets the hits, so that a query that stopped with PAIRS_FULL can be resumed. Copy them
 * first.
 */
punctual_status punctual_workspace_drain_ray_hits(struct punctual_workspace *workspace);

/**
 * Makes room for at least so many hits, 24 bytes each.
 *
 * Fails with OUT_OF_MEMORY if there is not that much.
 */
punctual_status punctual_workspace_reserve_ray_hits(struct punctual_workspace *workspace, size_t hits);

/**
 * What `punctual_ray_batch_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_ray_batch_init(struct punctual_ray_batch *batch,
                             size_t size,
                             const struct punctual_tree *tree,
                             const struct punctual_ray *rays,
                             size_t count);

/**
 * The question for the nearest hit of each of `count` rays. Checked when it is run.
 */
PUNCTUAL_INLINE punctual_ray_batch punctual_ray_batch_new(const struct punctual_tree *tree,
                                                          const struct punctual_ray *rays,
                                                          size_t count) {
  punctual_ray_batch batch;
  punctual_ray_batch_init(&batch, sizeof batch, tree, rays, count);
  return batch;
}

/**
 * Runs many rays within a budget, and writes the hits of those that are done to `hits`, which
 * has room for all. The first batch of so many rays in a workspace makes room for them, about
 * 100 bytes each; later ones do not allocate. It does not lock or panic. `clock` may be null:
 * the clock of the system.
 *
 * Fails with NULL, BAD_ARGUMENT, which names the ray, OUT_OF_MEMORY or POISONED before it has
 * begun.
 */
punctual_status punctual_ray_batch_run(const struct punctual_ray_batch *batch,
                                       struct punctual_workspace *workspace,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_ray_hit *hits,
                                       struct punctual_ray_batch_outcome *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget. The hits of all
 * rays that are done are written, those of earlier calls again.
 *
 * Fails as `punctual_ray_batch_run`, and with NOT_RESUMABLE if the last run in this workspace
 * was not of this very batch or is complete.
 */
punctual_status punctual_ray_batch_resume(const struct punctual_ray_batch *batch,
                                          struct punctual_workspace *workspace,
                                          struct punctual_budget budget,
                                          const struct punctual_clock *clock,
                                          struct punctual_ray_hit *hits,
                                          struct punctual_ray_batch_outcome *outcome);

/**
 * What the last run of this batch in the workspace has still to do. Takes time linear in the
 * rays, which it copies.
 *
 * Fails as `punctual_ray_batch_run`, and with NOT_RESUMABLE if the last run in this workspace
 * was not of this very batch.
 */
punctual_status punctual_ray_batch_remaining(const struct punctual_ray_batch *batch,
                                             const struct punctual_workspace *workspace,
                                             struct punctual_remaining *remaining);

/**
 * The hits that the last query found, if it was a ray query for all hits, without those
 * drained: in order of discovery, which is nearly that of `t`.
 * As many as `capacity` allows are written to `hits`,
 * and how many there are to `count`.
 */
punctual_status punctual_workspace_ray_hits(const struct punctual_workspace *workspace,
                                            struct punctual_ray_hit *hits,
                                            size_t capacity,
                                            size_t *count);

/* --------------------------------------------------------------------------------------------------------------------
 * 15. Points: are they inside a solid?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * Whether a point is inside a solid, or on its surface.
 */
enum punctual_inside
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Not known: the budget ended first, or the winding number of an open solid is 1/2 to its
   * error.
   */
  PUNCTUAL_INSIDE_UNDECIDED = 0,
  /**
   * It is.
   */
  PUNCTUAL_INSIDE_YES = 1,
  /**
   * It is not.
   */
  PUNCTUAL_INSIDE_NO = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_inside punctual_inside;
#else
typedef uint32_t punctual_inside;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What is proven about a point and a solid.
 */
typedef struct punctual_point_bounds {
  /**
   * How often the surface winds around the point: a whole number, exactly, if the solid is
   * closed. On the surface that of the points just beside it. NaN if it is not known.
   */
  double winding;
  /**
   * Bound of its error: 0 for closed solids, infinite if it is not known.
   */
  double error;
  /**
   * The signed distance, negative inside, is within `low` and `high`, if it was asked for;
   * else both are 0, and they are infinite for an empty mesh.
   */
  double low;
  /**
   * See `low`.
   */
  double high;
  /**
   * The nearest point of the surface that was found, if distances were asked for.
   */
  struct punctual_point nearest;
  /**
   * The triangle that has it, id of the input mesh; PUNCTUAL_NO_TRIANGLE without one.
   */
  uint32_t triangle;
  /**
   * Inside: the winding number is at least 1, of an open solid above 1/2, or the point is on
   * the surface.
   */
  punctual_inside inside;
  /**
   * 1 if the point is on the surface, exactly; else 0.
   */
  uint32_t is_on_surface;
  /**
   * Not used; 0.
   */
  uint32_t reserved;
} punctual_point_bounds;

/**
 * The answer for many points; what is known of each is in the caller's array.
 */
typedef struct punctual_points_outcome {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * The first so many points are done and their bounds are written.
   */
  size_t done;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * What it has done for all points.
   */
  struct punctual_stats stats;
} punctual_points_outcome;

/**
 * Asks about `count` points, in the frame of the tree's mesh, one after the other within one
 * budget, and writes what is known of those that are done to `bounds`, which has room for all.
 * `measures`: 0 for winding numbers only, else distances too. The first call for so many
 * points in a workspace makes room for them, about 100 bytes each. It does not lock or panic.
 * `clock` may be null: the clock of the system.
 *
 * Fails with NULL, BAD_ARGUMENT if the tree was not built as a solid or for a point that is
 * not finite, which it names, OUT_OF_MEMORY or POISONED before it has begun.
 */
punctual_status punctual_points_run(const struct punctual_tree *tree,
                                    const struct punctual_point *points,
                                    size_t count,
                                    uint32_t measures,
                                    struct punctual_workspace *workspace,
                                    struct punctual_budget budget,
                                    const struct punctual_clock *clock,
                                    struct punctual_point_bounds *bounds,
                                    struct punctual_points_outcome *outcome);

/**
 * Goes on with the stopped run that the workspace holds, with a fresh budget; the points must
 * be what they were. What is known of all points that are done is written, those of earlier
 * calls again.
 *
 * Fails as `punctual_points_run`, and with NOT_RESUMABLE if the last run in this workspace was
 * not of these points or is complete.
 */
punctual_status punctual_points_resume(const struct punctual_tree *tree,
                                       const struct punctual_point *points,
                                       size_t count,
                                       uint32_t measures,
                                       struct punctual_workspace *workspace,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_point_bounds *bounds,
                                       struct punctual_points_outcome *outcome);

/**
 * What the last run about these points in the workspace has still to do. Takes time linear in
 * the points, which it checks.
 *
 * Fails as `punctual_points_run`, and with NOT_RESUMABLE if the last run in this workspace was
 * not of these points.
 */
punctual_status punctual_points_remaining(const struct punctual_tree *tree,
                                          const struct punctual_point *points,
                                          size_t count,
                                          uint32_t measures,
                                          const struct punctual_workspace *workspace,
                                          struct punctual_remaining *remaining);

/* --------------------------------------------------------------------------------------------------------------------
 * 16. Scenes: many bodies, one budget a frame
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * No group of a scene.
 */
#define PUNCTUAL_NO_GROUP UINT64_MAX

/**
 * What becomes of a contact of two bodies in a frame.
 */
enum punctual_contact_phase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * They touched when it was last decided, and this frame has not decided it.
   */
  PUNCTUAL_CONTACT_PHASE_UNDECIDED = 0,
  /**
   * They are proven to touch in this frame, and were not known to before.
   */
  PUNCTUAL_CONTACT_PHASE_BEGAN = 1,
  /**
   * They are proven to touch again.
   */
  PUNCTUAL_CONTACT_PHASE_PERSISTS = 2,
  /**
   * They are proven to be apart, or one was removed, or they may not meet any more, or both
   * are fixed and their distance is asked for no more.
   */
  PUNCTUAL_CONTACT_PHASE_ENDED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_contact_phase punctual_contact_phase;
#else
typedef uint32_t punctual_contact_phase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a scene asks of a pair of bodies.
 */
enum punctual_pair_question
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Whether they meet.
   */
  PUNCTUAL_PAIR_QUESTION_MEET = 0,
  /**
   * How far apart they are.
   */
  PUNCTUAL_PAIR_QUESTION_DISTANCE = 1,
  /**
   * Until when they are free.
   */
  PUNCTUAL_PAIR_QUESTION_MOTION = 2,
  /**
   * Where they touch.
   */
  PUNCTUAL_PAIR_QUESTION_CONTACTS = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_pair_question punctual_pair_question;
#else
typedef uint32_t punctual_pair_question;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Whether a body can meet others of its kind.
 */
enum punctual_body_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Meets moving and fixed bodies.
   */
  PUNCTUAL_BODY_KIND_MOVING = 0,
  /**
   * Part of the surroundings: two fixed bodies are not compared, unless their distance is
   * asked for. It may be given new poses all the same: a kinematic body, which moves as the
   * program says and which nothing pushes, is a fixed one with a new pose in each frame, or
   * a motion (`punctual_scene_set_motion`) so that nothing slips through it.
   */
  PUNCTUAL_BODY_KIND_FIXED = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_body_kind punctual_body_kind;
#else
typedef uint32_t punctual_body_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Which boxes the broad phase compares.
 */
enum punctual_reach
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Those around the bodies where they are: pairs that are not reported do not meet.
   */
  PUNCTUAL_REACH_HERE = 0,
  /**
   * Swept boxes: each covers a body's motion since the previous frame, at a constant
   * velocity and turn between its two poses. Pairs that may have met in between are reported
   * as well, with what is true of them here.
   */
  PUNCTUAL_REACH_SWEPT = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_reach punctual_reach;
#else
typedef uint32_t punctual_reach;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Bodies that move, and the question which of them meet. One thread at a time may use it; it
 * may start threads of its own.
 */
typedef struct punctual_scene punctual_scene;

/**
 * A tree at a pose. Made by `punctual_body_new`; the scene shares the tree, so any number of
 * bodies may have the same.
 */
typedef struct punctual_body {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Its tree.
   */
  const struct punctual_tree *tree;
  /**
   * Maps coordinates of the mesh to those of the scene.
   */
  struct punctual_pose pose;
  /**
   * A `punctual_body_kind`; moving by default.
   */
  uint32_t kind;
  /**
   * The groups it belongs to, a bit each; all by default.
   */
  uint32_t groups;
  /**
   * The groups it meets, if they meet its own; all by default.
   */
  uint32_t mask;
  /**
   * How much its pairs matter when the budget does not reach all; 0 by default. A pair
   * counts as the more important of its two bodies, and goes before all that are less
   * important.
   */
  float importance;
  /**
   * By how much its surface is thickened, 0 by default: pairs meet when they come within the
   * sum of their margins.
   */
  double margin;
  /**
   * Whether it is a sensor, false by default: what meets it or is inside it is told, but its
   * pairs have no contact points, unless those of a pair are asked for
   * (`punctual_scene_find_contacts_of`).
   */
  bool is_sensor;
  /**
   * Any value of yours, 0 by default; the scene ignores it.
   */
  uint64_t data;
} punctual_body;

/**
 * Names a body of one scene for as long as it is in it. The id of a removed body is never valid
 * again.
 */
typedef struct punctual_body_id {
  /**
   * A small number that no other body now in the scene has; those of removed bodies are given
   * out again.
   */
  uint32_t index;
  /**
   * Tells bodies of the same index apart.
   */
  uint32_t generation;
  /**
   * Tells scenes of this process apart; no other scene takes the id for one of its own. It is no
   * part of what the id says: compare and store `index` and `generation`. 0: every scene takes
   * the id for its own.
   */
  uint32_t scene;
} punctual_body_id;

/**
 * What a frame found. If `unplaced`, `unpaired` and `unlisted` are 0, bodies that are not in
 * `pairs` together, and may meet, do not: their boxes are apart. Otherwise the budget ended in
 * the broad phase, which goes on in the next frame.
 */
typedef struct punctual_report {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Frames so far, this one included.
   */
  uint64_t frame;
  /**
   * How many pairs `punctual_scene_pairs` has.
   */
  size_t pair_count;
  /**
   * How many of them are decided in this frame; the others are undecided.
   */
  size_t decided;
  /**
   * How many of them are proven to intersect.
   */
  size_t intersecting;
  /**
   * How many of them are proven to come within their margins; not among the intersecting
   * ones.
   */
  size_t within;
  /**
   * How many of them are complete.
   */
  size_t complete;
  /**
   * The largest age of a pair.
   */
  uint64_t worst_age;
  /**
   * Bodies that changed or were removed and whose boxes are not up to date: the next frames
   * place them.
   */
  size_t unplaced;
  /**
   * Bodies that not all partners are known of: they moved on or were removed, and the search
   * for pairs is not at its end.
   */
  size_t unpaired;
  /**
   * Known pairs that were not looked at. They are not in `pairs`, and are undecided.
   */
  size_t unlisted;
  /**
   * Whether pairs were left out because there are as many as a scene keeps, 1,048,576.
   */
  bool is_full;
  /**
   * Work of the queries, and 250 units for each that was begun.
   */
  uint64_t work;
  /**
   * Work of the broad phase: placing bodies, finding pairs and listing them.
   */
  uint64_t broad_phase_work;
  /**
   * BV tests of the queries.
   */
  uint64_t bv_tests;
  /**
   * Time of the frame in nanoseconds; -1 if it was not measured, which it is only under a
   * time budget.
   */
  int64_t elapsed;
} punctual_report;

/**
 * What is known about two bodies whose boxes overlap.
 */
typedef struct punctual_pair_report {
  /**
   * The body of the lower index: A of the pair.
   */
  struct punctual_body_id a;
  /**
   * The other one.
   */
  struct punctual_body_id b;
  /**
   * Whether their surfaces meet, in this frame.
   */
  punctual_verdict verdict;
  /**
   * Whether nothing is left to find, of its distance and its time of impact too, if they are
   * asked for. Undecided all the same if rounding hides whether bodies with margins meet, or
   * bodies in motion at its start.
   */
  bool complete;
  /**
   * If they meet, two triangles that do; if they come within their margins, two that do;
   * else zeros.
   */
  struct punctual_triangle_pair witness;
  /**
   * How far apart the witness is at most, in the length unit of the scene, margins not
   * subtracted: 0 if they intersect, above 0 and no more than the margins if they come
   * within them, and infinite without a witness.
   */
  double witness_distance;
  /**
   * Intersecting pairs of triangles found; at most 1 for MODE_ANY, and of bodies with
   * margins, whose witness counts.
   */
  uint64_t found;
  /**
   * Probability that the surfaces meet, 0 to 1; 0 or 1 if that is decided, 0.5 if the pair
   * is complete all the same.
   */
  double probability;
  /**
   * Expected share of the intersecting pairs of triangles that was found: 1 if complete, 0
   * if nothing was found, and between them otherwise.
   */
  double recall;
  /**
   * Frames since it was decided: 0 if it was in this one.
   */
  uint64_t age;
} punctual_pair_report;

/**
 * What is not known about a pair.
 */
typedef struct punctual_pair_certificate {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * No more triangle pairs than this intersect.
   */
  uint64_t upper_bound;
  /**
   * Each intersection that was not found lies in a box no longer than this, in the length
   * unit of the scene.
   */
  double largest_extent;
} punctual_pair_certificate;

/**
 * The question which body a ray hits. Plain data, made by `punctual_scene_ray_new`.
 */
typedef struct punctual_scene_ray {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * A `punctual_ray_mode`; RAY_MODE_NEAREST by default.
   */
  uint32_t mode;
  /**
   * The ray, in the coordinates of the scene.
   */
  struct punctual_ray ray;
  /**
   * Only bodies that a body of these groups and this mask may meet are asked; all by
   * default.
   */
  uint32_t groups;
  /**
   * See `groups`; all by default.
   */
  uint32_t mask;
  /**
   * See `has_body`.
   */
  struct punctual_body_id body;
  /**
   * Not 0: only other bodies are asked that `body` may meet.
   */
  uint32_t has_body;
} punctual_scene_ray;

/**
 * A triangle of a body that a ray meets.
 */
typedef struct punctual_body_hit {
  /**
   * The body; zeros without a hit.
   */
  struct punctual_body_id body;
  /**
   * The triangle, or PUNCTUAL_NO_TRIANGLE, and the parameter of the ray, which is the same
   * in the scene.
   */
  struct punctual_ray_hit on_body;
} punctual_body_hit;

/**
 * Which body a ray hits, wherever the search stopped.
 */
typedef struct punctual_scene_ray_cast {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * The nearest hit of those found; for RAY_MODE_ANY the one found.
   */
  struct punctual_body_hit hit;
  /**
   * How many triangles were found to be hit; for RAY_MODE_ALL those of
   * `punctual_scene_ray_hits`.
   */
  uint64_t found;
  /**
   * Proven: no hit that was not found lies before this parameter. Of a nearest hit that is
   * known, its own; infinite if nothing is left to be found.
   */
  double free_until;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * Work done.
   */
  uint64_t work;
  /**
   * Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
   * time budget.
   */
  int64_t elapsed;
} punctual_scene_ray_cast;

/**
 * A contact of two bodies. It begins and ends in frames that prove it; between two of them
 * bodies may have parted and met again unseen.
 */
typedef struct punctual_body_contact {
  /**
   * The body of the lower index.
   */
  struct punctual_body_id a;
  /**
   * The other one.
   */
  struct punctual_body_id b;
  /**
   * What becomes of it in this frame.
   */
  punctual_contact_phase phase;
  /**
   * Frames since it began: 0 in the frame in which it did.
   */
  uint64_t age;
} punctual_body_contact;

/**
 * What is known of the distance of two bodies, in the length unit of the scene.
 */
typedef struct punctual_pair_distance {
  /**
   * The body of the lower index.
   */
  struct punctual_body_id a;
  /**
   * The other one.
   */
  struct punctual_body_id b;
  /**
   * Proven: no point of one surface was closer to the other; 0 if nothing is known.
   */
  double low;
  /**
   * Proven: the distance of `triangles`, and 0 only if the surfaces met; infinite if nothing
   * is known.
   */
  double high;
  /**
   * Whether triangles were found; if not, they are zeros.
   */
  bool has_triangles;
  /**
   * The closest triangles that were found.
   */
  struct punctual_triangle_pair triangles;
  /**
   * Frames since this was proven: 0 if it holds for the bodies where they are in this frame.
   * As many as there were if nothing is known.
   */
  uint64_t age;
} punctual_pair_distance;

/**
 * Until when two bodies are apart, of which one or both move; times from 0, this frame, to 1,
 * the end of their motions. If their distance is asked for too, that is the one at time 0.
 */
typedef struct punctual_pair_passage {
  /**
   * The body of the lower index.
   */
  struct punctual_body_id a;
  /**
   * The other one.
   */
  struct punctual_body_id b;
  /**
   * Proven: they meet at no time before. 1 without a contact: they are free to the end. 0 if
   * the budget did not reach the pair.
   */
  double free_until;
  /**
   * Whether a contact was found (yet); if not, its time and the triangles are zeros.
   */
  bool touches;
  /**
   * Proven: they meet at this time.
   */
  double touching_at;
  /**
   * The triangles that meet then.
   */
  struct punctual_triangle_pair triangles;
} punctual_pair_passage;

/**
 * A point where two bodies touch: one of at most four of a manifold, fixed to both bodies.
 */
typedef struct punctual_contact_point {
  /**
   * The manifold that it belongs to: the same from frame to frame while the manifold keeps a
   * point.
   */
  uint64_t manifold;
  /**
   * The same from frame to frame while the point stays near its place on one of the bodies.
   */
  uint64_t id;
  /**
   * The point on the body of the lower index, in the coordinates of its mesh, and on the
   * other one, in those of its own.
   */
  struct punctual_point points[2];
  /**
   * Unit vector in the coordinates of the first body, from the second to the first.
   */
  struct punctual_point normal;
  /**
   * Signed distance along the normal where it was found, without margins; negative where the
   * bodies are sunk into each other.
   */
  double distance;
} punctual_contact_point;

/**
 * Where two bodies touch.
 */
typedef struct punctual_contact_points {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * How many points there are; at most 16.
   */
  size_t count;
  /**
   * The surfaces were at least so far apart wherever no point stands for a contact when the
   * points were found, margins not subtracted; 0 if one body is within the other, or nothing
   * is known.
   */
  double low;
  /**
   * How far the surfaces have moved relative to each other since then, at most; infinite if
   * nothing is known.
   */
  double drift;
  /**
   * Frames since this was found. As many as there were if nothing is known.
   */
  uint64_t age;
  /**
   * 1 if the body of the lower index was inside the other, 2 if the other was inside it, or
   * had a vertex in it, while their surfaces did not meet; else 0. No point stands for that.
   */
  uint64_t within;
} punctual_contact_points;

/**
 * What is known of the least distance between two groups of bodies, in the length unit of the
 * scene. It holds for the bodies where they are in this frame, whatever the budget reached.
 */
typedef struct punctual_group_distance {
  /**
   * Of which groups: the id of `punctual_scene_measure_groups`.
   */
  uint64_t id;
  /**
   * Proven: no point of one group is closer to the other; 0 if nothing is known, and
   * infinite if no two of their bodies may meet.
   */
  double low;
  /**
   * Proven: the groups are no farther apart, and 0 only if bodies of them met; infinite if
   * nothing is known.
   */
  double high;
  /**
   * Whether bodies prove `high`; if not, it is that of boxes, and the bodies and triangles
   * are zeros.
   */
  bool has_bodies;
  /**
   * These bodies, the lower index first.
   */
  struct punctual_body_id bodies[2];
  /**
   * Their closest triangles that were found; zeros for none.
   */
  struct punctual_triangle_pair triangles;
  /**
   * How many pairs of bodies may still be closer, or are to be measured. 0: `high - low` is
   * within the tolerance.
   */
  size_t open;
} punctual_group_distance;

/**
 * What is asked about the bodies of a scene: a tree at a pose or on its way, or a point. Plain
 * data, made by `punctual_scene_shape_new`.
 */
typedef struct punctual_scene_shape {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * Not 0: only other bodies are asked that `body` may meet.
   */
  uint32_t has_body;
  /**
   * Its tree; null for a point, the start of `motion`, which then has no turn.
   */
  const struct punctual_tree *tree;
  /**
   * Its way from time 0 to 1, in the coordinates of the scene. All questions but that of a
   * cast are about its start.
   */
  struct punctual_motion motion;
  /**
   * A length by which it is thickened: a point is then a ball; 0 by default.
   */
  double margin;
  /**
   * Only bodies that a body of these groups and this mask may meet are asked; all by
   * default.
   */
  uint32_t groups;
  /**
   * See `groups`; all by default.
   */
  uint32_t mask;
  /**
   * See `has_body`.
   */
  struct punctual_body_id body;
  /**
   * 0.
   */
  uint32_t reserved;
} punctual_scene_shape;

/**
 * Where a shape touches a body, or is closest to it.
 */
typedef struct punctual_shape_hit {
  /**
   * The body; zeros without one.
   */
  struct punctual_body_id body;
  /**
   * Whether there is a body.
   */
  bool is_there;
  /**
   * Whether triangles and points were found; not if one is inside the other. If not, they
   * are zeros.
   */
  bool has_points;
  /**
   * Whether there is a normal; not where the triangles intersect. If not, it is zero.
   */
  bool has_normal;
  /**
   * Triangle of the body, triangle of the shape.
   */
  struct punctual_triangle_pair triangles;
  /**
   * Their closest points in the coordinates of the scene, of the body and of the shape, each
   * moved towards the other by its margin.
   */
  struct punctual_point points[2];
  /**
   * Unit vector from the body to the shape.
   */
  struct punctual_point normal;
} punctual_shape_hit;

/**
 * What a shape meets on its way; times from 0 to 1.
 */
typedef struct punctual_shape_cast {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * Proven: it meets no body before. 1 without a hit: it is free to its end.
   */
  double free_until;
  /**
   * Proven: it meets the body of `hit` at this time; 0 without one.
   */
  double touching_at;
  /**
   * The body, with points and normal just before.
   */
  struct punctual_shape_hit hit;
  /**
   * Work done.
   */
  uint64_t work;
  /**
   * Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
   * time budget.
   */
  int64_t elapsed;
} punctual_shape_cast;

/**
 * The body closest to a shape, wherever the search stopped.
 */
typedef struct punctual_closest_body {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * Proven: no body is closer, margins subtracted; infinite if there is none at all.
   */
  double low;
  /**
   * Proven: the body of `hit` is no farther; 0 if they meet, infinite if none was found.
   */
  double high;
  /**
   * The closest body found.
   */
  struct punctual_shape_hit hit;
  /**
   * Work done.
   */
  uint64_t work;
  /**
   * Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
   * time budget.
   */
  int64_t elapsed;
} punctual_closest_body;

/**
 * A body that a shape meets.
 */
typedef struct punctual_body_overlap {
  /**
   * The body.
   */
  struct punctual_body_id body;
  /**
   * How they meet.
   */
  punctual_verdict verdict;
  /**
   * Triangles of the body and of the shape that prove it; as of `punctual_outcome`.
   */
  struct punctual_triangle_pair witness;
} punctual_body_overlap;

/**
 * How many bodies a shape meets, wherever the search stopped.
 */
typedef struct punctual_overlap {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Why it returned.
   */
  punctual_stop_reason stop;
  /**
   * How many bodies are proven to meet it.
   */
  uint64_t met;
  /**
   * How many bodies have boxes that overlap its own and were not decided.
   */
  uint64_t undecided;
  /**
   * 1: all other bodies are proven not to meet it. 0 if the budget ended before all boxes
   * were compared, or of MODE_ANY, if a first body was enough.
   */
  uint64_t is_whole;
  /**
   * Work done.
   */
  uint64_t work;
  /**
   * Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
   * time budget.
   */
  int64_t elapsed;
} punctual_overlap;

/**
 * What `punctual_body_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_body_init(struct punctual_body *body,
                        size_t size,
                        const struct punctual_tree *tree,
                        struct punctual_pose pose);

/**
 * A moving body that may meet all others. Checked when it is inserted.
 */
PUNCTUAL_INLINE punctual_body punctual_body_new(const struct punctual_tree *tree, struct punctual_pose pose) {
  punctual_body body;
  punctual_body_init(&body, sizeof body, tree, pose);
  return body;
}

/**
 * Frees a scene and ends its threads; null is fine.
 */
void punctual_scene_free(struct punctual_scene *scene);

/**
 * Makes a scene without bodies. `mode` is a `punctual_mode` (any intersection of each pair, or
 * the number of all), `reach` a `punctual_reach`.
 *
 * Fails with BAD_ARGUMENT if one of them is unknown.
 */
punctual_status punctual_scene_new(uint32_t mode, uint32_t reach, struct punctual_scene **scene);

/**
 * Asks from the next frame on for any intersection of each pair, or for the number of all, by
 * a `punctual_mode`. What earlier frames found does not answer another question.
 *
 * Fails with BAD_ARGUMENT if it is unknown.
 */
punctual_status punctual_scene_set_mode(struct punctual_scene *scene, uint32_t mode);

/**
 * Says which boxes the broad phase compares from the next frame on, by a `punctual_reach`.
 *
 * Fails with BAD_ARGUMENT if it is unknown.
 */
punctual_status punctual_scene_set_reach(struct punctual_scene *scene, uint32_t reach);

/**
 * Keeps no more than so many pairs of near bodies; by default, and at most, 1,048,576. A pair
 * takes 88 bytes, and about 430 more from its first turn on. Pairs beyond that are left out,
 * and `is_full` of the report says so, until an eighth of the room is free again. Those that
 * are kept already stay.
 */
punctual_status punctual_scene_set_max_pairs(struct punctual_scene *scene, size_t pairs);

/**
 * Shares the work of `punctual_scene_detect` among `threads` threads, the caller's included.
 * They wait between frames.
 *
 * Fails with BAD_ARGUMENT if they are more than 1024, with NO_THREAD if the operating system
 * gives none; the scene then has those that it had.
 */
punctual_status punctual_scene_use_threads(struct punctual_scene *scene, size_t threads);

/**
 * Makes room for this many bodies, and for this many pairs of them whose boxes overlap or
 * nearly do. Within this room `punctual_scene_detect` does not allocate. Takes about 860 bytes
 * a body and 960 a pair.
 *
 * Fails with OUT_OF_MEMORY if there is not so much; the scene has the room that it had then.
 */
punctual_status punctual_scene_reserve(struct punctual_scene *scene, size_t bodies, size_t pairs);

/**
 * Puts a body into the scene.
 *
 * Fails with BAD_POSE if its pose is refused (a scene allows a little less than a query),
 * BAD_ARGUMENT if its kind is unknown or its importance NaN.
 */
punctual_status punctual_scene_insert(struct punctual_scene *scene,
                                      const struct punctual_body *body,
                                      struct punctual_body_id *id);

/**
 * Takes a body out of the scene. As for all that follows, fails with NO_SUCH_BODY if it is not
 * in it.
 */
punctual_status punctual_scene_remove(struct punctual_scene *scene, struct punctual_body_id id);

/**
 * A body as it is now, but for `tree`, which is null: see `punctual_scene_tree`.
 */
punctual_status punctual_scene_body(const struct punctual_scene *scene,
                                    struct punctual_body_id id,
                                    struct punctual_body *body);

/**
 * A new handle to the tree of a body, shared with the scene: the caller's, to be freed.
 */
punctual_status punctual_scene_tree(const struct punctual_scene *scene,
                                    struct punctual_body_id id,
                                    struct punctual_tree **tree);

/**
 * Moves a body. Setting the pose that it already has is a no-op.
 *
 * Fails with BAD_POSE if the pose is refused; the body then stays where it was.
 */
punctual_status punctual_scene_set_pose(struct punctual_scene *scene,
                                        struct punctual_body_id id,
                                        struct punctual_pose pose);

/**
 * Gives a body another tree.
 */
punctual_status punctual_scene_set_tree(struct punctual_scene *scene,
                                        struct punctual_body_id id,
                                        const struct punctual_tree *tree);

/**
 * Moves the vertices of a body's mesh, as `punctual_tree_refit_f32`. If handles or other
 * bodies share its tree, the body gets one of its own first.
 *
 * Fails with BAD_MESH if their number is another or a coordinate in use is not finite; the
 * shape is unchanged then.
 */
punctual_status punctual_scene_refit_f32(struct punctual_scene *scene,
                                         struct punctual_body_id id,
                                         const float *vertices,
                                         size_t vertex_count);

/**
 * Like `punctual_scene_refit_f32`.
 */
punctual_status punctual_scene_refit_f64(struct punctual_scene *scene,
                                         struct punctual_body_id id,
                                         const double *vertices,
                                         size_t vertex_count);

/**
 * Says whom a body may meet: `x` and `y` if `x.groups & y.mask` and `y.groups & x.mask` both
 * have a bit set.
 */
punctual_status punctual_scene_set_filter(struct punctual_scene *scene,
                                          struct punctual_body_id id,
                                          uint32_t groups,
                                          uint32_t mask);

/**
 * Says how much the pairs of a body matter.
 *
 * Fails with BAD_ARGUMENT if the importance is NaN.
 */
punctual_status punctual_scene_set_importance(struct punctual_scene *scene,
                                              struct punctual_body_id id,
                                              float importance);

/**
 * Finds out which bodies meet, within a budget for the whole frame. `clock` may be null: the
 * clock of the system; with one of the caller's, all is done on the calling thread. `report`
 * may be null.
 *
 * Under a time budget it ends in time as long as the broad phase alone does; under a work
 * budget, which does not count the broad phase, it gives the same report on any number of
 * threads. It allocates only as the scene grows: in a frame with more bodies, or with more
 * pairs of overlapping boxes, than any before it, and in the 64 frames after it had more
 * bodies than ever.
 */
punctual_status punctual_scene_detect(struct punctual_scene *scene,
                                      struct punctual_budget budget,
                                      const struct punctual_clock *clock,
                                      struct punctual_report *report);

/**
 * What the last frame found.
 */
punctual_status punctual_scene_report(const struct punctual_scene *scene, struct punctual_report *report);

/**
 * What the last frame found about two bodies, by binary search. `listed` says whether it has
 * the pair; if not, `pair` is left alone.
 */
punctual_status punctual_scene_pair(const struct punctual_scene *scene,
                                    struct punctual_body_id x,
                                    struct punctual_body_id y,
                                    struct punctual_pair_report *pair,
                                    size_t pair_size,
                                    bool *listed);

/**
 * Whether the last frame knew all bodies that this one may meet: it was placed where it is,
 * and the search for its partners came to its end. Of two such bodies that may meet and are
 * not in `punctual_scene_pairs` together the boxes are apart if `unlisted` of the report is 0.
 */
punctual_status punctual_scene_partners_known(const struct punctual_scene *scene,
                                              struct punctual_body_id id,
                                              bool *known);

/**
 * What the last frame left open about two bodies. Takes time linear in what is open. Fails
 * with BAD_ARGUMENT if both are the same.
 */
punctual_status punctual_scene_certificate(const struct punctual_scene *scene,
                                           struct punctual_body_id x,
                                           struct punctual_body_id y,
                                           struct punctual_pair_certificate *certificate);

/**
 * The ids of all bodies, by index.
 * As many as `capacity` allows are written to `ids`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_bodies(const struct punctual_scene *scene,
                                      struct punctual_body_id *ids,
                                      size_t capacity,
                                      size_t *count);

/**
 * The pairs of the last frame: all that may meet and whose boxes overlap, or whose distance is
 * asked for, ascending by index, as far as they are known and listed.
 * As many as `capacity` allows are written to `pairs`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_pairs(const struct punctual_scene *scene,
                                     struct punctual_pair_report *pairs,
                                     size_t pairs_size,
                                     size_t capacity,
                                     size_t *count);

/**
 * Thickens a body by a margin, a length. Its pairs are said to meet when they come within the
 * sum of their margins.
 *
 * Fails with BAD_ARGUMENT if the margin is not from 0 to 2^1000.
 */
punctual_status punctual_scene_set_margin(struct punctual_scene *scene, struct punctual_body_id id, double margin);

/**
 * From the next frame on `punctual_scene_contacts` tells which pairs of bodies begin to touch,
 * go on, and part. Off by default.
 */
punctual_status punctual_scene_track_contacts(struct punctual_scene *scene);

/**
 * Asks for the distance of two bodies in every frame from now on, wherever they are, if they
 * may meet by their filters; their margins count. The pair is in the report as well and shares
 * the budget like any other. A frame is done with it when `high - low` is no more than
 * `tolerance`, a length. Asked again, it has another tolerance.
 *
 * Fails with BAD_ARGUMENT if both bodies are the same, or the tolerance is not from 0 to
 * 2^1000.
 */
punctual_status punctual_scene_measure(struct punctual_scene *scene,
                                       struct punctual_body_id x,
                                       struct punctual_body_id y,
                                       double tolerance);

/**
 * Asks for the distance of two bodies no more. Nothing changes if it was not asked for. Fails
 * with BAD_ARGUMENT if both are the same.
 */
punctual_status punctual_scene_stop_measuring(struct punctual_scene *scene,
                                              struct punctual_body_id x,
                                              struct punctual_body_id y);

/**
 * Moves a body to where a motion begins, and says where it goes until the next frame, time 1.
 * It stays so until `punctual_scene_set_pose` or another motion. A pair whose distance is
 * asked for has both: its distance at time 0, and its time of impact.
 *
 * Fails with BAD_POSE or BAD_ARGUMENT if the motion is refused; the body then stays where it
 * was.
 */
punctual_status punctual_scene_set_motion(struct punctual_scene *scene,
                                          struct punctual_body_id id,
                                          struct punctual_motion motion);

/**
 * What `punctual_scene_ray_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_scene_ray_init(struct punctual_scene_ray *scene_ray, size_t size, struct punctual_ray ray);

/**
 * The question for the nearest hit of a ray in a scene. Checked when it is cast.
 */
PUNCTUAL_INLINE punctual_scene_ray punctual_scene_ray_new(struct punctual_ray ray) {
  punctual_scene_ray scene_ray;
  punctual_scene_ray_init(&scene_ray, sizeof scene_ray, ray);
  return scene_ray;
}

/**
 * Casts a ray within a budget of its own. `clock` may be null: the clock of the system. Every
 * body is seen at the pose that was set last, whether there was a frame since or not; those
 * that changed since are looked at one by one, so cast rays after `punctual_scene_detect`
 * rather than before it. It allocates only in a scene with more bodies, or for more hits, than
 * any before.
 *
 * Fails with BAD_ARGUMENT if the ray is refused, or has no image in the coordinates of a
 * body's mesh.
 */
punctual_status punctual_scene_cast(struct punctual_scene *scene,
                                    const struct punctual_scene_ray *ray,
                                    struct punctual_budget budget,
                                    const struct punctual_clock *clock,
                                    struct punctual_scene_ray_cast *cast);

/**
 * The contacts of the last frame, ascending by index. None unless they are tracked.
 * As many as `capacity` allows are written to `contacts`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_contacts(const struct punctual_scene *scene,
                                        struct punctual_body_contact *contacts,
                                        size_t contacts_size,
                                        size_t capacity,
                                        size_t *count);

/**
 * The distances of the last frame that are asked for, ascending by index, whether their pairs
 * had a turn or not.
 * As many as `capacity` allows are written to `distances`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_distances(const struct punctual_scene *scene,
                                         struct punctual_pair_distance *distances,
                                         size_t distances_size,
                                         size_t capacity,
                                         size_t *count);

/**
 * Until when the pairs of the last frame are free of which one or both bodies have a motion,
 * ascending by index. Others, if `unplaced`, `unpaired` and `unlisted` of the report are 0, do
 * not meet on their way.
 * As many as `capacity` allows are written to `passages`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_passages(const struct punctual_scene *scene,
                                        struct punctual_pair_passage *passages,
                                        size_t passages_size,
                                        size_t capacity,
                                        size_t *count);

/**
 * The hits of the last cast, if it was for all hits: of one body after the other, in order of
 * discovery.
 * As many as `capacity` allows are written to `hits`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_ray_hits(const struct punctual_scene *scene,
                                        struct punctual_body_hit *hits,
                                        size_t capacity,
                                        size_t *count);

/**
 * Puts bodies into the scene as the parts of one compound, which is at `pose`: the pose of
 * each is its place in the frame of the compound. Parts are bodies like others, but those of
 * one compound never meet. Where a part is, is the product of both poses, rounded; one that is
 * moved by itself goes back into its place with the next pose or motion of the compound.
 *
 * Fails as `punctual_scene_insert`; the scene is then as it was.
 */
punctual_status punctual_scene_insert_compound(struct punctual_scene *scene,
                                               struct punctual_pose pose,
                                               const struct punctual_body *parts,
                                               size_t part_count,
                                               uint64_t *compound);

/**
 * The parts of a compound, in the order in which they were given, without those that were
 * removed: as many as `capacity` allows are written to `ids`, and how many there are to
 * `count`. As for all that follows, fails with BAD_ARGUMENT if the compound is not in the
 * scene.
 */
punctual_status punctual_scene_parts(const struct punctual_scene *scene,
                                     uint64_t compound,
                                     struct punctual_body_id *ids,
                                     size_t capacity,
                                     size_t *count);

/**
 * The compound that a body is a part of. `is_part` says whether there is one; if not,
 * `compound` is left alone.
 */
punctual_status punctual_scene_compound_of(const struct punctual_scene *scene,
                                           struct punctual_body_id id,
                                           uint64_t *compound,
                                           bool *is_part);

/**
 * Moves all parts of a compound.
 *
 * Fails with BAD_POSE if a part cannot be where it would be; all then stay where they were.
 */
punctual_status punctual_scene_set_compound_pose(struct punctual_scene *scene,
                                                 uint64_t compound,
                                                 struct punctual_pose pose);

/**
 * Gives a compound a motion: each of its parts goes with it, about the same axis.
 *
 * Fails with BAD_POSE or BAD_ARGUMENT if the motion is refused, or a part cannot be where it
 * would be at its beginning or end; all then stay where they were.
 */
punctual_status punctual_scene_set_compound_motion(struct punctual_scene *scene,
                                                   uint64_t compound,
                                                   struct punctual_motion motion);

/**
 * Takes a compound out of the scene, with all of its parts.
 */
punctual_status punctual_scene_remove_compound(struct punctual_scene *scene, uint64_t compound);

/**
 * Asks for the least distance between two groups of bodies in every frame from now on; margins
 * count, and pairs that may not meet by their filters do not. No pair is asked about that is
 * farther apart than the closest less the tolerance, a length.
 *
 * Both groups may have bodies in common, or be one: a body has no distance from itself.
 *
 * Fails with BAD_ARGUMENT if both are one and the same body, or the tolerance not from 0 to
 * 2^1000.
 */
punctual_status punctual_scene_measure_groups(struct punctual_scene *scene,
                                              const struct punctual_body_id *x,
                                              size_t x_count,
                                              const struct punctual_body_id *y,
                                              size_t y_count,
                                              double tolerance,
                                              uint64_t *id);

/**
 * Asks for the distance of two groups no more.
 *
 * Fails with BAD_ARGUMENT if it is not asked for.
 */
punctual_status punctual_scene_stop_measuring_groups(struct punctual_scene *scene, uint64_t id);

/**
 * Ignores a pair of bodies from the next frame on, or does no longer: it may not meet, as if
 * filters excluded it. Forgotten with one of its bodies. Fails with BAD_ARGUMENT if both
 * bodies are the same.
 */
punctual_status punctual_scene_ignore(struct punctual_scene *scene,
                                      struct punctual_body_id x,
                                      struct punctual_body_id y,
                                      bool ignores);

/**
 * Finds where bodies touch from the next frame on, of all pairs that meet:
 * `punctual_scene_contact_points`.
 */
punctual_status punctual_scene_find_contacts(struct punctual_scene *scene);

/**
 * The same of two bodies, whenever they meet. Fails with BAD_ARGUMENT if both are the same.
 */
punctual_status punctual_scene_find_contacts_of(struct punctual_scene *scene,
                                                struct punctual_body_id x,
                                                struct punctual_body_id y);

/**
 * Finds where bodies touch of all pairs of which one is in the groups `groups` and the other
 * in `mask`, by their own filters (`punctual_scene_set_filter`), from the next frame on.
 * Several calls add up; all bits for both are `punctual_scene_find_contacts`.
 */
punctual_status punctual_scene_find_contacts_between(struct punctual_scene *scene, uint32_t groups, uint32_t mask);

/**
 * Ends `punctual_scene_find_contacts_between` of these groups, or, with all bits for both,
 * `punctual_scene_find_contacts`. Nothing changes if there was no such call. Contacts of pairs
 * that are asked for otherwise are found as before.
 */
punctual_status punctual_scene_stop_finding_contacts_between(struct punctual_scene *scene,
                                                             uint32_t groups,
                                                             uint32_t mask);

/**
 * Does not ask for the contacts of two bodies any more, but as one of all pairs or of those
 * between groups. Fails with BAD_ARGUMENT if both are the same.
 */
punctual_status punctual_scene_stop_finding_contacts_of(struct punctual_scene *scene,
                                                        struct punctual_body_id x,
                                                        struct punctual_body_id y);

/**
 * Where two bodies touch, as far as the frames up to the last have found, if that is asked
 * for; no points if they were found apart. As many as `capacity` allows are written to
 * `points`, the deepest manifold first, and what is known of all to `found`. Fails with
 * BAD_ARGUMENT if both bodies are the same.
 */
punctual_status punctual_scene_contact_points(const struct punctual_scene *scene,
                                              struct punctual_body_id x,
                                              struct punctual_body_id y,
                                              struct punctual_contact_point *points,
                                              size_t points_size,
                                              size_t capacity,
                                              struct punctual_contact_points *found);

/**
 * Sets how far apart bodies are found out to be whose contacts are asked for and that have
 * none, besides their margins: up to so far, or to four fifths of their distance, `low` of
 * `punctual_contact_points` tells it. 0 by default.
 *
 * Fails with BAD_ARGUMENT if it is not from 0 to 2^1000.
 */
punctual_status punctual_scene_set_look_ahead(struct punctual_scene *scene, double length);

/**
 * How far a body may move from where it is before it could touch another one where no contact
 * point stands, or sink into it there by more than `sink`; at most `stride`. If all moving
 * bodies move no farther after each frame, and the fixed ones rest, none sinks in deeper
 * there, whatever the budgets. Pairs whose contacts are not asked for do not count.
 */
punctual_status punctual_scene_may_move(struct punctual_scene *scene,
                                        struct punctual_body_id id,
                                        double stride,
                                        double sink,
                                        double *most);

/**
 * Says how much a question, a `punctual_pair_question`, matters beside the bodies that it is
 * asked of; 0 by default.
 *
 * Fails with BAD_ARGUMENT if the question is unknown, or the importance infinite or NaN.
 */
punctual_status punctual_scene_set_question_importance(struct punctual_scene *scene,
                                                       uint32_t question,
                                                       float importance);

/**
 * The distances of groups of the last frame.
 * As many as `capacity` allows are written to `distances`,
 * and how many there are to `count`.
 */
punctual_status punctual_scene_group_distances(const struct punctual_scene *scene,
                                               struct punctual_group_distance *distances,
                                               size_t distances_size,
                                               size_t capacity,
                                               size_t *count);

/**
 * What `punctual_scene_shape_new` calls: writes as many bytes as the caller's struct has.
 */
void punctual_scene_shape_init(struct punctual_scene_shape *shape,
                               size_t size,
                               const struct punctual_tree *tree,
                               struct punctual_motion motion);

/**
 * A shape without a margin, which asks all bodies. `tree` may be null: a point. Checked when
 * it is asked about.
 */
PUNCTUAL_INLINE punctual_scene_shape punctual_scene_shape_new(const struct punctual_tree *tree,
                                                              struct punctual_motion motion) {
  punctual_scene_shape shape;
  punctual_scene_shape_init(&shape, sizeof shape, tree, motion);
  return shape;
}

/**
 * Finds which body a shape meets first on its way, within a budget of its own. `clock` may be
 * null: the clock of the system. Bodies are where they were put last; their own motions do not
 * count. Their margins do.
 *
 * Fails with BAD_POSE or BAD_ARGUMENT if the shape is refused, and with NO_SUCH_BODY.
 */
punctual_status punctual_scene_cast_shape(struct punctual_scene *scene,
                                          const struct punctual_scene_shape *shape,
                                          struct punctual_budget budget,
                                          const struct punctual_clock *clock,
                                          struct punctual_shape_cast *cast);

/**
 * Finds the body that is closest to a shape and no farther than `within`, 0 to infinity.
 * Otherwise as `punctual_scene_cast_shape`.
 */
punctual_status punctual_scene_closest(struct punctual_scene *scene,
                                       const struct punctual_scene_shape *shape,
                                       double within,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_closest_body *closest);

/**
 * Finds the bodies that a shape meets, MODE_ALL or MODE_ANY of them; of two solids, what is
 * inside meets. As many as there is room for are written to `met` and to `undecided`, by
 * index; how many there are is in `overlap`. Otherwise as `punctual_scene_cast_shape`.
 */
punctual_status punctual_scene_overlap(struct punctual_scene *scene,
                                       const struct punctual_scene_shape *shape,
                                       uint32_t mode,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_body_overlap *met,
                                       size_t met_size,
                                       size_t met_capacity,
                                       struct punctual_body_id *undecided,
                                       size_t undecided_capacity,
                                       struct punctual_overlap *overlap);

/**
 * Casts `count` rays one after another within one budget, each as `punctual_scene_cast`, and
 * writes their answers to `casts`. How many of them are answered, from the first, is written
 * to `done`; the others are free until 0. With threads of the scene, a batch of more than 64
 * rays is shared among them, unless work is limited or the clock is the caller's; a budget of
 * work, or none, gives the same bits on any number of them.
 *
 * Fails with BAD_ARGUMENT for the first ray that is refused.
 */
punctual_status punctual_scene_cast_rays(struct punctual_scene *scene,
                                         const struct punctual_scene_ray *rays,
                                         size_t count,
                                         struct punctual_budget budget,
                                         const struct punctual_clock *clock,
                                         struct punctual_scene_ray_cast *casts,
                                         size_t casts_size,
                                         size_t *done);

/**
 * The group of this name, a text in UTF-8; made if the scene has none yet.
 */
punctual_status punctual_scene_group(struct punctual_scene *scene, const char *name, uint64_t *group);

/**
 * Moves a body to a group, or with PUNCTUAL_NO_GROUP out of its group.
 *
 * Fails with BAD_ARGUMENT if the scene has no such group.
 */
punctual_status punctual_scene_set_group(struct punctual_scene *scene, struct punctual_body_id id, uint64_t group);

/**
 * Ignores all pairs of a body of one group and a body of the other from the next frame on, or
 * (`ignores` is false) does no longer; twice the same group: its bodies do not meet each
 * other.
 *
 * Fails with BAD_ARGUMENT if the scene has no such group.
 */
punctual_status punctual_scene_ignore_groups(struct punctual_scene *scene, uint64_t x, uint64_t y, bool ignores);

/* --------------------------------------------------------------------------------------------------------------------
 * 17. Robots: is a motion free?
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * No shape of a robot.
 */
#define PUNCTUAL_NO_SHAPE UINT32_MAX

/**
 * What is known of a configuration or a motion.
 */
enum punctual_robot_verdict
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The budget ended first, or shapes come too near to be told apart.
   */
  PUNCTUAL_ROBOT_VERDICT_UNDECIDED = 0,
  /**
   * Proven: no two shapes meet.
   */
  PUNCTUAL_ROBOT_VERDICT_FREE = 1,
  /**
   * Proven: two shapes meet.
   */
  PUNCTUAL_ROBOT_VERDICT_CONTACT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum punctual_robot_verdict punctual_robot_verdict;
#else
typedef uint32_t punctual_robot_verdict;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A controller that follows a plan no faster than is proven, from cycle to cycle. What was
 * proven of the plan stays proven: each cycle goes on from there. The speed of a cycle is the
 * largest from which the robot can still stop within the part of the plan that is proven; if
 * nothing can be proven, it brakes along the plan, where it was proven free before. Obstacles
 * that move by themselves are checked anew in each cycle: tell where they are before
 * `punctual_horizon_step`.
 */
typedef struct punctual_horizon punctual_horizon;

/**
 * A robot among obstacles, with all that one thread needs to ask about it. Lengths are in
 * metres, angles in radians. A configuration has a number for each joint that moves and
 * follows no other, in the order of the URDF file.
 */
typedef struct punctual_robot punctual_robot;

/**
 * A motion of all joints: pieces one after the other, each with a polynomial of time for each
 * joint. Lines, splines and braking are such motions.
 */
typedef struct punctual_trajectory punctual_trajectory;

/**
 * Whether a configuration collides.
 */
typedef struct punctual_robot_collision {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * The answer.
   */
  punctual_robot_verdict verdict;
  /**
   * The shapes that meet, or PUNCTUAL_NO_SHAPE twice.
   */
  uint32_t shapes[2];
  /**
   * Why the call returned.
   */
  punctual_stop_reason stop;
  /**
   * Units of work done.
   */
  uint64_t work;
} punctual_robot_collision;

/**
 * The least distance of all pairs of shapes: `low <= distance <= high`, in metres, whenever it
 * stopped.
 */
typedef struct punctual_robot_clearance {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Why the call returned.
   */
  punctual_stop_reason stop;
  /**
   * Proven; infinite if no pair is asked.
   */
  double low;
  /**
   * Proven; infinite if nothing was measured yet.
   */
  double high;
  /**
   * The closest shapes found, or PUNCTUAL_NO_SHAPE twice.
   */
  uint32_t shapes[2];
  /**
   * Their closest points, in the world; the origin if one holds the other.
   */
  struct punctual_point points[2];
  /**
   * The unit vector from the first of them to the second; 0 if they are one point.
   */
  struct punctual_point normal;
  /**
   * Units of work done.
   */
  uint64_t work;
} punctual_robot_clearance;

/**
 * A pair of shapes that are near each other: `low <= what is left of their distance above
 * their margin <= high`, in metres.
 */
typedef struct punctual_robot_near_pair {
  /**
   * The shapes, the lower one first.
   */
  uint32_t shapes[2];
  /**
   * Proven.
   */
  double low;
  /**
   * Proven.
   */
  double high;
  /**
   * Their closest points, in the world; the origin if one holds the other.
   */
  struct punctual_point points[2];
  /**
   * The unit vector from the first of them to the second; 0 if they are one point.
   */
  struct punctual_point normal;
} punctual_robot_near_pair;

/**
 * What `punctual_robot_near_pairs` found.
 */
typedef struct punctual_robot_near {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Why the call returned.
   */
  punctual_stop_reason stop;
  /**
   * Number of pairs.
   */
  size_t count;
  /**
   * Proven: no less is left of the pairs that were not found; `within` at least, unless the
   * budget ended first.
   */
  double beyond;
  /**
   * Units of work done.
   */
  uint64_t work;
} punctual_robot_near;

/**
 * What is known of a motion. Times are shares of an edge (0 to 1), or seconds of a horizon.
 */
typedef struct punctual_robot_motion {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * The answer for all of the motion.
   */
  punctual_robot_verdict verdict;
  /**
   * Proven: no contact before.
   */
  double free_until;
  /**
   * Proven: contact then; infinite if none was found.
   */
  double touching_at;
  /**
   * The shapes that meet then, or PUNCTUAL_NO_SHAPE twice.
   */
  uint32_t shapes[2];
  /**
   * Why the call returned.
   */
  punctual_stop_reason stop;
  /**
   * Units of work done.
   */
  uint64_t work;
} punctual_robot_motion;

/**
 * What a `punctual_horizon` knows at the end of a cycle. Times are those of the plan, in
 * seconds.
 */
typedef struct punctual_ahead {
  /**
   * Its size in bytes, to be set before the call.
   */
  uint32_t size;
  /**
   * Cycles since the last one that was proven for the obstacles' motions of now.
   */
  uint32_t since;
  /**
   * The share of the full speed, 0 to 1, at the end of the cycle that begins now.
   */
  double speed;
  /**
   * The time of the plan then: `punctual_trajectory_at` tells where to bring the joints.
   */
  double time;
  /**
   * The time of the plan at which the robot stands if it brakes from then on.
   */
  double stops_at;
  /**
   * Proven: no contact before this time of the plan with what stands still, nor among links.
   */
  double free_until;
  /**
   * Whether this cycle, and braking after it, is proven free, of obstacles that move by
   * themselves as told `since` cycles ago. False if it was not yet proven since an obstacle
   * was added, moved or removed, or a margin was set.
   */
  bool is_proven;
  /**
   * Whether the plan that was given is followed from this cycle on.
   */
  bool is_new;
  /**
   * Why the call returned.
   */
  punctual_stop_reason stop;
  /**
   * Units of work done.
   */
  uint64_t work;
} punctual_ahead;

/**
 * Frees a robot; null is fine.
 */
void punctual_robot_free(struct punctual_robot *robot);

/**
 * Reads a robot from a URDF file. `srdf` may be null, or names the file whose disabled pairs
 * of links are not asked; without it, links joined by one moving joint are not. `packages` may
 * be null, or names a folder in which `package://` names are sought, before those above the
 * URDF file. With `solids` other than 0 closed meshes are solids: what is inside them
 * collides. What is not heeded in the files, `punctual_robot_notices` tells.
 *
 * Fails with BAD_FILE; the text names the file, the line, and the link or joint.
 */
punctual_status punctual_robot_from_urdf(const char *urdf,
                                         const char *srdf,
                                         const char *packages,
                                         uint32_t solids,
                                         struct punctual_robot **robot);

/**
 * The number of values of a configuration.
 */
punctual_status punctual_robot_joints(const struct punctual_robot *robot, size_t *joints);

/**
 * The name of a joint of the configuration, by its index there; written as that of a shape
 * (`punctual_robot_shape_name`).
 *
 * Fails with BAD_ARGUMENT if there is no such joint.
 */
punctual_status punctual_robot_joint_name(const struct punctual_robot *robot,
                                          size_t joint,
                                          char *name,
                                          size_t capacity,
                                          size_t *length);

/**
 * The limits of a joint of the configuration, in radians or metres; infinite without. They are
 * not enforced.
 *
 * Fails with BAD_ARGUMENT if there is no such joint.
 */
punctual_status punctual_robot_joint_limits(const struct punctual_robot *robot,
                                            size_t joint,
                                            double *lower,
                                            double *upper);

/**
 * The name of a link, by its index in the URDF file; written as that of a shape.
 *
 * Fails with BAD_ARGUMENT if there is no such link.
 */
punctual_status punctual_robot_link_name(const struct punctual_robot *robot,
                                         size_t link,
                                         char *name,
                                         size_t capacity,
                                         size_t *length);

/**
 * Where the links are in the world at a configuration, in the order of the URDF file. As many
 * as `capacity` allows are written to `poses`, and how many there are to `count`. Allocates.
 *
 * Fails as `punctual_robot_collide`.
 */
punctual_status punctual_robot_link_poses(const struct punctual_robot *robot,
                                          const double *values,
                                          size_t joints,
                                          struct punctual_pose *poses,
                                          size_t capacity,
                                          size_t *count);

/**
 * The name of a shape: that of its link or of the obstacle, as UTF-8 that ends with a zero
 * byte. As much as `capacity` allows is written to `name`; its whole length, without the zero
 * byte, to `length`.
 *
 * Fails with BAD_ARGUMENT if there is no such shape.
 */
punctual_status punctual_robot_shape_name(const struct punctual_robot *robot,
                                          uint32_t shape,
                                          char *name,
                                          size_t capacity,
                                          size_t *length);

/**
 * What the files of a robot say that is not heeded, a line each: pairs of links that the robot
 * does not have, elements that are passed over, open meshes that were to be solids. Empty for
 * most. As much as `capacity` allows is written to `notices`, and ends with a zero byte; its
 * whole length, without the zero byte, to `length`.
 */
punctual_status punctual_robot_notices(const struct punctual_robot *robot,
                                       char *notices,
                                       size_t capacity,
                                       size_t *length);

/**
 * Adds an obstacle, which shares the tree: a solid if it was built as one and is closed, else
 * a surface. With `link` null it stands at a pose in the world; otherwise it moves with that
 * link, at a pose in the frame of the link, and is not asked with it, nor, in either case,
 * with the `may_touch_count` links whose names are in `may_touch`. Its number is written to
 * `shape`.
 *
 * Fails with BAD_POSE if the pose is off a rotation by more than 1e-6, and with BAD_ARGUMENT
 * if there is no such link.
 */
punctual_status punctual_robot_add(struct punctual_robot *robot,
                                   const char *name,
                                   const struct punctual_tree *tree,
                                   struct punctual_pose pose,
                                   const char *link,
                                   const char *const *may_touch,
                                   size_t may_touch_count,
                                   uint32_t *shape);

/**
 * Moves an obstacle to another pose, in the frame in which it was added.
 *
 * Fails with BAD_ARGUMENT if there is no such obstacle, and as `punctual_robot_add`.
 */
punctual_status punctual_robot_move(struct punctual_robot *robot, uint32_t shape, struct punctual_pose pose);

/**
 * Removes an obstacle.
 *
 * Fails with BAD_ARGUMENT if there is no such obstacle.
 */
punctual_status punctual_robot_remove(struct punctual_robot *robot, uint32_t shape);

/**
 * Makes an obstacle in the world move by itself, from a pose at time 0 on: with a linear
 * velocity (m/s), and turning about its origin with an angular one (rad/s), both in the frame
 * of the world. Each of its points may be `reach` metres from there, and farther by
 * `reach_speed` (m/s) with time. It counts in edges and horizons, which begin at time 0;
 * collisions and clearances are of time 0. `punctual_robot_move` ends its motion.
 *
 * Fails with BAD_ARGUMENT if there is no such obstacle, it is attached to a link, or a number
 * is not finite, and with BAD_POSE.
 */
punctual_status punctual_robot_move_along(struct punctual_robot *robot,
                                          uint32_t shape,
                                          struct punctual_pose pose,
                                          struct punctual_point linear,
                                          struct punctual_point angular,
                                          double reach,
                                          double reach_speed);

/**
 * Sets how far apart shapes must be, in metres: 0 at first. Shapes that are no farther apart
 * count as in contact; a clearance is what is left above the margin. With `name` null it is
 * for all pairs; else for those of this link or obstacle, in addition. With `other` too, for
 * pairs of these two, in place of all others. With `padding` other than 0 and a name, for
 * pairs of this link, or of what is attached to it, and obstacles in the world, in addition.
 *
 * Fails with BAD_ARGUMENT if there is no link or obstacle of a name, the margin is negative,
 * NaN or more than 1e30, or `other` comes without `name`, or with `padding`.
 */
punctual_status punctual_robot_set_margin(struct punctual_robot *robot,
                                          double margin,
                                          const char *name,
                                          const char *other,
                                          uint32_t padding);

/**
 * Tells whether two links or obstacles may touch: pairs that may (not 0) are not checked. What
 * was told last of a pair counts, before what the files and `punctual_robot_add` say; pairs
 * that never move relative to each other stay unchecked. Lists all pairs anew.
 *
 * Fails with BAD_ARGUMENT if there is no link or obstacle of a name.
 */
punctual_status punctual_robot_allow(struct punctual_robot *robot, const char *x, const char *y, uint32_t may_touch);

/**
 * Whether a configuration of `joints` values collides, within a budget; `clock` may be null:
 * the clock of the system. It does not lock or panic, and allocates nothing but room for more
 * pairs or intervals than ever before.
 *
 * Fails with BAD_ARGUMENT if the robot has another number of joint values, or one is not
 * finite.
 */
punctual_status punctual_robot_collide(struct punctual_robot *robot,
                                       const double *values,
                                       size_t joints,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_robot_collision *collision);

/**
 * All pairs of shapes that meet, by ascending numbers: two numbers a pair, as many pairs as
 * `capacity` allows to `shapes`, which has room for `2 * capacity` numbers, and how many there
 * are to `count`. All of them, unless the budget ends. Allocates.
 *
 * Fails as `punctual_robot_collide`.
 */
punctual_status punctual_robot_collide_all(struct punctual_robot *robot,
                                           const double *values,
                                           size_t joints,
                                           struct punctual_budget budget,
                                           const struct punctual_clock *clock,
                                           uint32_t *shapes,
                                           size_t capacity,
                                           size_t *count,
                                           struct punctual_robot_collision *collision);

/**
 * The least distance of all pairs of shapes at a configuration: bounds that are `tolerance`
 * metres apart, unless the budget ends.
 *
 * Fails as `punctual_robot_collide`, and with BAD_ARGUMENT if the tolerance is negative or not
 * finite.
 */
punctual_status punctual_robot_measure(struct punctual_robot *robot,
                                       const double *values,
                                       size_t joints,
                                       double tolerance,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_robot_clearance *clearance);

/**
 * All pairs of shapes of which no more than `within` metres is left above their margin, by
 * ascending numbers, each with bounds that are `tolerance` metres apart, unless the budget
 * ends. As many as `capacity` allows are written to `pairs`, and how many there are to
 * `near->count`. `gradients` may be null, or has room for `capacity * joints` numbers: how the
 * distance of each pair changes with each joint, in m/rad or m/m; 0 of points that touch.
 * Allocates.
 *
 * Fails as `punctual_robot_measure`, and with BAD_ARGUMENT if `within` is negative or not
 * finite.
 */
punctual_status punctual_robot_near_pairs(struct punctual_robot *robot,
                                          const double *values,
                                          size_t joints,
                                          double within,
                                          double tolerance,
                                          struct punctual_budget budget,
                                          const struct punctual_clock *clock,
                                          struct punctual_robot_near_pair *pairs,
                                          size_t pair_size,
                                          double *gradients,
                                          size_t capacity,
                                          struct punctual_robot_near *near);

/**
 * Whether the straight line in joint space between two configurations is free: proven for all
 * of it, not at samples. With `first` other than 0 the first contact is sought, not any.
 *
 * Fails as `punctual_robot_collide`.
 */
punctual_status punctual_robot_edge(struct punctual_robot *robot,
                                    const double *from,
                                    const double *to,
                                    size_t joints,
                                    uint32_t first,
                                    struct punctual_budget budget,
                                    const struct punctual_clock *clock,
                                    struct punctual_robot_motion *motion);

/**
 * Whether a path is free: the straight lines from each of `count` configurations, one after the
 * other in `knots`, to the next one. Times count the lines. Otherwise as
 * `punctual_robot_edge`.
 *
 * Fails as `punctual_robot_collide`, and with BAD_ARGUMENT for fewer than two configurations.
 */
punctual_status punctual_robot_path(struct punctual_robot *robot,
                                    const double *knots,
                                    size_t count,
                                    size_t joints,
                                    uint32_t first,
                                    struct punctual_budget budget,
                                    const struct punctual_clock *clock,
                                    struct punctual_robot_motion *motion);

/**
 * Whether a motion along polynomials of time is free, as `punctual_robot_edge` for a line;
 * times are in seconds. Pieces need not join; both ends of each count. Goes on by
 * `punctual_robot_edge_resume`.
 *
 * Fails with BAD_ARGUMENT if it has another number of joints, or no piece.
 */
punctual_status punctual_robot_follow(struct punctual_robot *robot,
                                      const struct punctual_trajectory *trajectory,
                                      uint32_t first,
                                      struct punctual_budget budget,
                                      const struct punctual_clock *clock,
                                      struct punctual_robot_motion *motion);

/**
 * Continues the last edge, which its budget has stopped. However it is cut into pieces by work
 * budgets, the answer at the end is that of one uninterrupted call.
 *
 * Fails with NOT_RESUMABLE if it is done, or another question was asked or an obstacle changed
 * since.
 */
punctual_status punctual_robot_edge_resume(struct punctual_robot *robot,
                                           struct punctual_budget budget,
                                           const struct punctual_clock *clock,
                                           struct punctual_robot_motion *motion);

/**
 * For how long the robot is free if its joints go on at this velocity (rad/s or m/s), at most
 * for `seconds`. The near future is proven first, so a budget that ends early leaves a shorter
 * `free_until`.
 *
 * Fails as `punctual_robot_collide`.
 */
punctual_status punctual_robot_horizon(struct punctual_robot *robot,
                                       const double *values,
                                       const double *velocity,
                                       size_t joints,
                                       double seconds,
                                       struct punctual_budget budget,
                                       const struct punctual_clock *clock,
                                       struct punctual_robot_motion *motion);

/**
 * The seconds in which joints with these velocities stop, all in proportion, so that they stay
 * on their straight line, if each can decelerate so much (rad/s^2 or m/s^2).
 *
 * Fails with NULL.
 */
punctual_status punctual_robot_braking_time(const double *velocity,
                                            const double *decelerations,
                                            size_t joints,
                                            double *seconds);

/**
 * The largest share of the speed (0 to 1) with which a robot that is proven free for `free_until`
 * seconds may go on for `cycle` seconds, and then still stop in time. `braking` is the time in
 * which it stops from the full speed, at a constant deceleration.
 */
double punctual_robot_safe_speed(double free_until, double cycle, double braking);

/**
 * Frees a trajectory; null is fine.
 */
void punctual_trajectory_free(struct punctual_trajectory *trajectory);

/**
 * Frees a controller; null is fine.
 */
void punctual_horizon_free(struct punctual_horizon *horizon);

/**
 * Makes a trajectory without a piece.
 */
punctual_status punctual_trajectory_new(struct punctual_trajectory **trajectory);

/**
 * Adds a piece of this duration. `coefficients` holds `powers * joints` numbers: row `k` has
 * those of the `k`-th power of the time in seconds since the piece began, one for each joint,
 * in rad or m. Whether pieces join is not checked.
 *
 * Fails with BAD_ARGUMENT, which names the piece and the row, for another number of joints
 * than in the first piece, a duration that is not above 0, and numbers that are not finite or
 * beyond 1e30 within the piece. The trajectory is as before then.
 */
punctual_status punctual_trajectory_push(struct punctual_trajectory *trajectory,
                                         double seconds,
                                         const double *coefficients,
                                         size_t powers,
                                         size_t joints);

/**
 * The duration, in seconds.
 */
punctual_status punctual_trajectory_seconds(const struct punctual_trajectory *trajectory, double *seconds);

/**
 * Where the joints are at a time; at its ends before and after it. As many values as
 * `capacity` allows are written to `values`, and how many there are to `count`.
 */
punctual_status punctual_trajectory_at(const struct punctual_trajectory *trajectory,
                                       double seconds,
                                       double *values,
                                       size_t capacity,
                                       size_t *count);

/**
 * Takes all pieces away.
 */
punctual_status punctual_trajectory_clear(struct punctual_trajectory *trajectory);

/**
 * Makes a controller of a robot at rest, without a plan, with cycles of this duration, which
 * stops from the full speed of its plans within `braking`
 * (`punctual_robot_braking_time`), both in seconds.
 *
 * Fails with BAD_ARGUMENT unless `cycle` is above 0, and both are finite and not negative.
 */
punctual_status punctual_horizon_new(double cycle, double braking, struct punctual_horizon **horizon);

/**
 * Tells the speed of the cycle that begins now, within a budget; `clock` may be null: the
 * clock of the system. `plan` is a new one, which begins where the robot is and at the
 * velocity that it has there, or null. It is followed if this cycle and braking after it can
 * be proven, or the robot rests; else the robot brakes along the old one. However short the
 * budget, the speed changes by at most `cycle / braking`.
 *
 * Fails with BAD_ARGUMENT for a plan of another number of joints, and without any plan.
 * Nothing is changed then: braking as told before remains right.
 */
punctual_status punctual_horizon_step(struct punctual_horizon *horizon,
                                      struct punctual_robot *robot,
                                      const struct punctual_trajectory *plan,
                                      struct punctual_budget budget,
                                      const struct punctual_clock *clock,
                                      struct punctual_ahead *ahead);

/* --------------------------------------------------------------------------------------------------------------------
 * 18. Calibration: probabilities that learn
 * -------------------------------------------------------------------------------------------------------------------- */

/**
 * A correction of the probabilities that estimates tell, learned on the caller's own work: one
 * for each pair of parts whose queries are stopped, or for a scene, which learns by itself.
 * Plain data: to go on with it another day, store its numbers.
 */
typedef struct punctual_calibration {
  /**
   * Its size in bytes, as made.
   */
  uint32_t size;
  /**
   * What is added to the logit of a probability, -8 to 8; 0 at first.
   */
  double offset;
  /**
   * What the logit is multiplied with before, 1/8 to 8; 1 at first.
   */
  double slope;
  /**
   * What both go by: sums over the moments learned.
   */
  double evidence[3];
} punctual_calibration;

/**
 * What `punctual_calibration_default` calls: writes as many bytes as the caller's struct has.
 */
void punctual_calibration_init(struct punctual_calibration *calibration, size_t size);

/**
 * One that knows nothing and changes nothing.
 */
PUNCTUAL_INLINE punctual_calibration punctual_calibration_default(void) {
  punctual_calibration calibration;
  punctual_calibration_init(&calibration, sizeof calibration);
  return calibration;
}

/**
 * The corrected probability. It rises with the one given, and only 0 and 1 become 0 and 1;
 * what is beyond counts as these, and NaN as .5.
 *
 * Fails with BAD_ARGUMENT if the numbers of the calibration are none that can be learned.
 */
punctual_status punctual_calibration_apply(const struct punctual_calibration *calibration,
                                           double probability,
                                           double *corrected);

/**
 * Learns from a moment: the probability that `punctual_query_estimate` told then, before
 * `punctual_calibration_apply`, and whether the surfaces met at that pose: 0 or not 0. What
 * was told as certain, or NaN, teaches nothing. Takes about a microsecond.
 *
 * Fails as `punctual_calibration_apply`.
 */
punctual_status punctual_calibration_learn(struct punctual_calibration *calibration, double told, uint32_t met);

/**
 * What a scene has learned: the probability of a pair whose query was stopped includes it.
 */
punctual_status punctual_scene_calibration(const struct punctual_scene *scene,
                                           struct punctual_calibration *calibration);

/**
 * Goes on with what was learned before, by another scene with parts of the same kind, say.
 *
 * Fails as `punctual_calibration_apply`.
 */
punctual_status punctual_scene_set_calibration(struct punctual_scene *scene,
                                               const struct punctual_calibration *calibration);

#ifdef __cplusplus
} // extern "C"
#endif

#endif /* PUNCTUAL_H */

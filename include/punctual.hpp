/*
 * punctual for C++17: the handles of punctual.h as move-only types that free themselves. Header only, a thin layer: no call
 * does more than the one of the same name in punctual.h, where units, ownership, threads and errors are told.
 *
 * No exceptions are thrown and none are needed (-fno-exceptions and -fno-rtti are fine). What can fail returns a Result, or a
 * punctual_status where there is no value. Who takes the value of a Result that has none ends the process, in every build: the
 * text of the failure goes to standard error. Copies of a handle's pointer (get()) must not outlive it.
 */

#ifndef PUNCTUAL_HPP
#define PUNCTUAL_HPP

#include "punctual.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace punctual {

/** What went wrong in the last call on this thread that failed. */
inline const char *last_error() noexcept { return punctual_last_error(); }

namespace detail {

/** Ends the process: a value was taken that is not there. */
[[noreturn]] inline void no_value(punctual_status status) noexcept {
  std::fprintf(stderr, "punctual: the value of a failure was taken (status %u); the last error is: %s\n",
               static_cast<unsigned>(status), last_error());
  std::abort();
}

/** Whether a struct of punctual.h begins with its size. */
template <class T, class = void> struct CarriesSize : std::false_type {};
template <class T>
struct CarriesSize<T, std::enable_if_t<std::is_same_v<decltype(T::size), std::uint32_t>>> : std::true_type {};

} // namespace detail

/** A struct of punctual.h, all zeros but for its size: a place to be written. */
template <class T> T sized() noexcept {
  T value{};
  if constexpr (detail::CarriesSize<T>::value)
    value.size = sizeof(T);
  return value;
}

/** A value, or the status that tells why there is none. */
template <class T> class [[nodiscard]] Result {
public:
  Result(T value) noexcept : value_(std::move(value)) {}
  /** Without a value, PUNCTUAL_STATUS_OK is no status. */
  Result(punctual_status failure) noexcept
      : status_(failure != PUNCTUAL_STATUS_OK ? failure : PUNCTUAL_STATUS_BAD_ARGUMENT) {}

  explicit operator bool() const noexcept { return value_.has_value(); }
  punctual_status status() const noexcept { return status_; }

  /** The value. Without one the process ends. */
  T &value() &noexcept { return check(), *value_; }
  const T &value() const &noexcept { return check(), *value_; }
  T value() &&noexcept { return check(), std::move(*value_); }
  T &operator*() &noexcept { return value(); }
  const T &operator*() const &noexcept { return value(); }
  T operator*() &&noexcept { return std::move(*this).value(); }
  T *operator->() noexcept { return &value(); }
  const T *operator->() const noexcept { return &value(); }

  /** The value, or another one if there is none. */
  T value_or(T other) &&noexcept { return value_ ? std::move(*value_) : std::move(other); }

private:
  void check() const noexcept {
    if (!value_)
      detail::no_value(status_);
  }

  punctual_status status_ = PUNCTUAL_STATUS_OK;
  std::optional<T> value_;
};

/** Elements that somebody else owns. */
template <class T> struct Span {
  const T *data;
  std::size_t size;

  const T *begin() const noexcept { return data; }
  const T *end() const noexcept { return data + size; }
};

namespace detail {

/** Owns a handle. */
template <class H, void (*Free)(H *)> class Handle {
public:
  Handle() noexcept = default;
  explicit Handle(H *handle) noexcept : handle_(handle) {}

  /** For the functions of punctual.h; null after a move. */
  H *get() noexcept { return handle_.get(); }
  const H *get() const noexcept { return handle_.get(); }

private:
  struct Deleter {
    void operator()(H *handle) const noexcept { Free(handle); }
  };
  std::unique_ptr<H, Deleter> handle_;
};

/** The handle that a function writes to the place behind its other arguments, as a T. */
template <class T, class H, class Function, class... Arguments>
Result<T> owned(Function function, Arguments... arguments) noexcept {
  H *handle = nullptr;
  punctual_status status = function(arguments..., &handle);
  if (status != PUNCTUAL_STATUS_OK)
    return status;
  return T(handle);
}

/** The value that a function writes to the place behind its other arguments. */
template <class T, class Function, class... Arguments>
Result<T> filled(Function function, Arguments... arguments) noexcept {
  T value = sized<T>();
  punctual_status status = function(arguments..., &value);
  if (status != PUNCTUAL_STATUS_OK)
    return status;
  return value;
}

} // namespace detail

inline punctual_pose identity() noexcept { return punctual_pose_identity(); }

inline Result<punctual_pose> pose_from_quaternion(double x, double y, double z, double w,
                                                  punctual_point translation) noexcept {
  return detail::filled<punctual_pose>(punctual_pose_from_quaternion, x, y, z, w, translation);
}

inline Result<punctual_pose> compose(const punctual_pose &outer, const punctual_pose &inner) noexcept {
  return detail::filled<punctual_pose>(punctual_pose_compose, outer, inner);
}

inline Result<punctual_pose> inverse(const punctual_pose &of) noexcept {
  return detail::filled<punctual_pose>(punctual_pose_inverse, of);
}

inline punctual_motion straight(const punctual_pose &start, const punctual_point &velocity) noexcept {
  return punctual_motion_straight(start, velocity);
}

inline Result<punctual_motion> screw(const punctual_pose &start, const punctual_pose &end) noexcept {
  return detail::filled<punctual_motion>(punctual_motion_screw, start, end);
}

/** Where the body is at a time, 0 to 1. */
inline Result<punctual_pose> pose_at(const punctual_motion &motion, double time) noexcept {
  return detail::filled<punctual_pose>(punctual_motion_pose, &motion, time);
}

inline punctual_ray ray(const punctual_point &origin, const punctual_point &direction) noexcept {
  return punctual_ray_new(origin, direction);
}

inline punctual_ray segment(const punctual_point &from, const punctual_point &to) noexcept {
  return punctual_ray_segment(from, to);
}

inline Result<bool> triangles_intersect(const punctual_triangle &a, const punctual_triangle &b) noexcept {
  return detail::filled<bool>(punctual_triangles_intersect, a, b);
}

/** The segment in which two triangles meet; empty if they do not. */
inline Result<std::optional<punctual_segment>> triangle_segment(const punctual_triangle &a,
                                                                const punctual_triangle &b) noexcept {
  punctual_segment segment{};
  bool meet = false;
  punctual_status status = punctual_triangle_segment(a, b, &segment, &meet);
  if (status != PUNCTUAL_STATUS_OK)
    return status;
  return meet ? std::optional(segment) : std::nullopt;
}

/** A correction of probabilities that knows nothing yet. */
inline punctual_calibration calibration() noexcept { return punctual_calibration_default(); }

inline Result<double> apply(const punctual_calibration &calibration, double probability) noexcept {
  return detail::filled<double>(punctual_calibration_apply, &calibration, probability);
}

/** What was told of a stopped query, and whether the surfaces met. */
[[nodiscard]] inline punctual_status learn(punctual_calibration &calibration, double told, bool met) noexcept {
  return punctual_calibration_learn(&calibration, told, met ? 1u : 0u);
}

inline punctual_budget unlimited() noexcept { return punctual_budget_unlimited(); }
inline punctual_budget time(std::uint64_t nanoseconds) noexcept { return punctual_budget_time(nanoseconds); }
inline punctual_budget work(std::uint64_t units) noexcept { return punctual_budget_work(units); }

class Mesh : public detail::Handle<punctual_mesh, punctual_mesh_free> {
public:
  using Handle::Handle;

  static Result<Mesh> make(const float *vertices, std::size_t vertex_count, const std::uint32_t *triangles,
                           std::size_t triangle_count) noexcept {
    return owned([&](punctual_mesh **mesh) {
      return punctual_mesh_new_f32(vertices, vertex_count, triangles, triangle_count, mesh);
    });
  }
  static Result<Mesh> make(const double *vertices, std::size_t vertex_count, const std::uint32_t *triangles,
                           std::size_t triangle_count) noexcept {
    return owned([&](punctual_mesh **mesh) {
      return punctual_mesh_new_f64(vertices, vertex_count, triangles, triangle_count, mesh);
    });
  }
  static Result<Mesh> read(const char *path) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_mesh_read(path, mesh); });
  }
  static Result<Mesh> read(const std::uint8_t *bytes, std::size_t count, punctual_format format) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_mesh_read_bytes(bytes, count, format, mesh); });
  }
  static Result<Mesh> icosphere(std::uint32_t subdivisions) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_shape_icosphere(subdivisions, mesh); });
  }
  static Result<Mesh> cuboid(float half_x, float half_y, float half_z, std::uint32_t cells) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_shape_cuboid(half_x, half_y, half_z, cells, mesh); });
  }
  static Result<Mesh> torus(float major, float minor, std::uint32_t resolution) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_shape_torus(major, minor, resolution, mesh); });
  }
  static Result<Mesh> torus_knot(std::uint32_t p, std::uint32_t q, float tube, std::uint32_t resolution) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_shape_torus_knot(p, q, tube, resolution, mesh); });
  }
  static Result<Mesh> gear(std::uint32_t teeth, std::uint32_t resolution) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_shape_gear(teeth, resolution, mesh); });
  }
  static Result<Mesh> height_field(std::uint32_t resolution, std::uint64_t seed) noexcept {
    return owned([&](punctual_mesh **mesh) { return punctual_shape_height_field(resolution, seed, mesh); });
  }

  Result<punctual_mesh_facts> describe() const noexcept {
    return detail::filled<punctual_mesh_facts>(punctual_mesh_describe, get());
  }
  Result<punctual_point> vertex(std::size_t index) const noexcept {
    return detail::filled<punctual_point>(punctual_mesh_vertex, get(), index);
  }
  /** Three for each triangle. */
  Result<const std::uint32_t *> indices() const noexcept {
    return detail::filled<const std::uint32_t *>(
        [&](const std::uint32_t **indices) { return punctual_mesh_indices(get(), indices); });
  }

private:
  template <class Make> static Result<Mesh> owned(Make make) noexcept {
    return detail::owned<Mesh, punctual_mesh>(make);
  }
};

class Tree : public detail::Handle<punctual_tree, punctual_tree_free> {
public:
  using Handle::Handle;

  static Result<Tree> build(const Mesh &mesh, const punctual_build_options &options =
                                                  punctual_build_options_default()) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_new, mesh.get(), &options);
  }
  /** A point cloud of `3 * count` coordinates, or balls of this radius. */
  static Result<Tree> from_points(const float *points, std::size_t count, double radius = 0) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_from_points_f32, points, count, radius);
  }
  static Result<Tree> from_points(const double *points, std::size_t count, double radius = 0) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_from_points_f64, points, count, radius);
  }
  /** Of a depth image of `count` depths, row by row. */
  static Result<Tree> from_depth(const punctual_depth_camera &camera, const float *depths, std::size_t count,
                                 double radius = 0) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_from_depth, camera, depths, count, radius);
  }
  static Result<Tree> ball(double radius) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_ball, radius);
  }
  static Result<Tree> capsule(double radius, double length) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_capsule, radius, length);
  }
  static Result<Tree> box(double x, double y, double z, double radius = 0) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_box, x, y, z, radius);
  }
  static Result<Tree> cylinder(double radius, double length) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_cylinder, radius, length);
  }
  static Result<Tree> cone(double radius, double length) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_cone, radius, length);
  }
  static Result<Tree> hull(const double *points, std::size_t count) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_hull, points, count);
  }
  static Result<Tree> height_field(const double *heights, std::size_t count, std::size_t columns, double step_x,
                                   double step_y) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_height_field, heights, count, columns, step_x, step_y);
  }
  static Result<Tree> from_bytes(const std::uint8_t *bytes, std::size_t count) noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_from_bytes, bytes, count);
  }

  /** A copy that is thickened by a ball. */
  Result<Tree> with_radius(double radius) const noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_tree_with_radius, get(), radius);
  }
  /** Writes up to `capacity` bytes; how many there are. */
  Result<std::size_t> to_bytes(std::uint8_t *bytes, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_tree_to_bytes, get(), bytes, capacity);
  }
  [[nodiscard]] punctual_status refit(const float *vertices, std::size_t vertex_count) noexcept {
    return punctual_tree_refit_f32(get(), vertices, vertex_count);
  }
  [[nodiscard]] punctual_status refit(const double *vertices, std::size_t vertex_count) noexcept {
    return punctual_tree_refit_f64(get(), vertices, vertex_count);
  }
  Result<Mesh> mesh() const noexcept {
    return detail::owned<Mesh, punctual_mesh>(punctual_tree_mesh, get());
  }
  Result<punctual_tree_facts> describe() const noexcept {
    return detail::filled<punctual_tree_facts>(punctual_tree_describe, get());
  }
  Result<punctual_mass_properties> mass_properties() const noexcept {
    return detail::filled<punctual_mass_properties>(punctual_tree_mass_properties, get());
  }
  /** Writes up to `capacity` levels; how many there are. */
  Result<std::size_t> levels(punctual_tree_level *levels, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_tree_levels, get(), levels, sizeof *levels, capacity);
  }
  /** Writes up to `capacity` alphas of nodes; how many there are. */
  Result<std::size_t> node_alphas(float *alphas, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_tree_node_alphas, get(), alphas, capacity);
  }
  [[nodiscard]] punctual_status validate() const noexcept { return punctual_tree_validate(get()); }
};

class Memory : public detail::Handle<punctual_memory, punctual_memory_free> {
public:
  using Handle::Handle;

  static Result<Memory> make() noexcept { return detail::owned<Memory, punctual_memory>(punctual_memory_new); }

  Result<punctual_memory_facts> describe() const noexcept {
    return detail::filled<punctual_memory_facts>(punctual_memory_describe, get());
  }
  /** Proven: how far apart the surfaces are at least at this pose; 0 if nothing is known. */
  Result<double> clearance(const Tree &a, const Tree &b, const punctual_pose &b_in_a) const noexcept {
    return detail::filled<double>(punctual_memory_clearance, get(), a.get(), b.get(), b_in_a);
  }
};

class Workspace : public detail::Handle<punctual_workspace, punctual_workspace_free> {
public:
  using Handle::Handle;

  static Result<Workspace> make() noexcept {
    return detail::owned<Workspace, punctual_workspace>(punctual_workspace_new);
  }
  static Result<Workspace> with_capacity(std::size_t queue, std::size_t pairs) noexcept {
    return detail::owned<Workspace, punctual_workspace>(punctual_workspace_with_capacity, queue, pairs);
  }

  [[nodiscard]] punctual_status set_cost_model(const punctual_cost_model &costs) noexcept {
    return punctual_workspace_set_cost_model(get(), &costs);
  }
  Result<punctual_cost_model> cost_model() const noexcept {
    return detail::filled<punctual_cost_model>(punctual_workspace_cost_model, get());
  }
  [[nodiscard]] punctual_status use_portable_kernels() noexcept {
    return punctual_workspace_use_portable_kernels(get());
  }
  /** Valid until the workspace is used again. */
  Result<Span<punctual_triangle_pair>> pairs() const noexcept {
    return detail::filled<Span<punctual_triangle_pair>>([&](Span<punctual_triangle_pair> *pairs) {
      return punctual_workspace_pairs(get(), &pairs->data, &pairs->size);
    });
  }
  [[nodiscard]] punctual_status drain_pairs() noexcept { return punctual_workspace_drain_pairs(get()); }
  /** Writes up to `capacity` contacts, the nearest first; how many there are. */
  Result<std::size_t> contacts(punctual_contact *contacts, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_workspace_contacts, get(), contacts, sizeof *contacts, capacity);
  }
  /** Writes up to `capacity` points of manifolds, those of the deepest first; how many there are. */
  Result<std::size_t> manifold_points(punctual_manifold_point *points, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_workspace_manifold_points, get(), points, sizeof *points, capacity);
  }
  [[nodiscard]] punctual_status drain_contacts() noexcept { return punctual_workspace_drain_contacts(get()); }
  [[nodiscard]] punctual_status reserve_contacts(std::size_t contacts) noexcept {
    return punctual_workspace_reserve_contacts(get(), contacts);
  }
  /** Writes up to `capacity` hits of a ray; how many there are. */
  Result<std::size_t> ray_hits(punctual_ray_hit *hits, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_workspace_ray_hits, get(), hits, capacity);
  }
  [[nodiscard]] punctual_status drain_ray_hits() noexcept { return punctual_workspace_drain_ray_hits(get()); }
  [[nodiscard]] punctual_status reserve_ray_hits(std::size_t hits) noexcept {
    return punctual_workspace_reserve_ray_hits(get(), hits);
  }
  /** Writes up to `capacity` points of a cloud; how many there are. */
  Result<std::size_t> near_points(std::uint32_t *points, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_workspace_near_points, get(), points, capacity);
  }
  [[nodiscard]] punctual_status drain_near_points() noexcept { return punctual_workspace_drain_near_points(get()); }
  [[nodiscard]] punctual_status reserve_near_points(std::size_t points) noexcept {
    return punctual_workspace_reserve_near_points(get(), points);
  }
};

/** A question. The fields of punctual_query are public; the trees must outlive it. */
struct Query : punctual_query {
  Query(const Tree &tree_a, const Tree &tree_b, const punctual_pose &pose_of_b) noexcept
      : punctual_query(punctual_query_new(tree_a.get(), tree_b.get(), pose_of_b)) {}
  Query(const Tree &&, const Tree &, const punctual_pose &) = delete;
  Query(const Tree &, const Tree &&, const punctual_pose &) = delete;
  Query(const Tree &&, const Tree &&, const punctual_pose &) = delete;

  Result<punctual_outcome> run(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                               const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_outcome>(punctual_query_run, this, workspace.get(), memory ? memory->get() : nullptr,
                                            budget, clock);
  }
  Result<punctual_outcome> resume(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                                  const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_outcome>(punctual_query_resume, this, workspace.get(),
                                            memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_prediction> predict(const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_prediction>(punctual_query_predict, this, memory ? memory->get() : nullptr);
  }
  Result<punctual_estimate> estimate(const Workspace &workspace, const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_estimate>(punctual_query_estimate, this, workspace.get(),
                                             memory ? memory->get() : nullptr);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace, const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_remaining>(punctual_query_remaining, this, workspace.get(),
                                              memory ? memory->get() : nullptr);
  }
  Result<punctual_certificate> certificate(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_certificate>(punctual_query_certificate, this, workspace.get());
  }
  /** Writes up to `capacity` boxes; how many there are. */
  Result<std::size_t> open_boxes(const Workspace &workspace, punctual_aabb *boxes,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_query_open_boxes, this, workspace.get(), boxes, capacity);
  }
};

/** Where does a surface intersect itself? The fields of punctual_self_query are public; the tree must outlive it. */
struct SelfQuery : punctual_self_query {
  explicit SelfQuery(const Tree &of) noexcept : punctual_self_query(punctual_self_query_new(of.get())) {}
  SelfQuery(const Tree &&) = delete;

  Result<punctual_outcome> run(Workspace &workspace, punctual_budget budget,
                               const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_outcome>(punctual_self_query_run, this, workspace.get(), budget, clock);
  }
  Result<punctual_outcome> resume(Workspace &workspace, punctual_budget budget,
                                  const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_outcome>(punctual_self_query_resume, this, workspace.get(), budget, clock);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_remaining>(punctual_self_query_remaining, this, workspace.get());
  }
  Result<punctual_certificate> certificate(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_certificate>(punctual_self_query_certificate, this, workspace.get());
  }
  /** Writes up to `capacity` boxes; how many there are. */
  Result<std::size_t> open_boxes(const Workspace &workspace, punctual_aabb *boxes,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_self_query_open_boxes, this, workspace.get(), boxes, capacity);
  }
};

/** How far apart? The fields of punctual_distance_query are public; the trees must outlive it. */
struct DistanceQuery : punctual_distance_query {
  DistanceQuery(const Tree &tree_a, const Tree &tree_b, const punctual_pose &pose_of_b) noexcept
      : punctual_distance_query(punctual_distance_query_new(tree_a.get(), tree_b.get(), pose_of_b)) {}
  DistanceQuery(const Tree &&, const Tree &, const punctual_pose &) = delete;
  DistanceQuery(const Tree &, const Tree &&, const punctual_pose &) = delete;
  DistanceQuery(const Tree &&, const Tree &&, const punctual_pose &) = delete;

  Result<punctual_distance> run(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                                const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_distance>(punctual_distance_query_run, this, workspace.get(),
                                             memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_distance> resume(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                                   const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_distance>(punctual_distance_query_resume, this, workspace.get(),
                                             memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_quantiles> predict(const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_quantiles>(punctual_distance_query_predict, this, memory ? memory->get() : nullptr);
  }
  Result<punctual_distance_estimate> estimate(const Workspace &workspace,
                                              const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_distance_estimate>(punctual_distance_query_estimate, this, workspace.get(),
                                                      memory ? memory->get() : nullptr);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace, const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_remaining>(punctual_distance_query_remaining, this, workspace.get(),
                                              memory ? memory->get() : nullptr);
  }
  Result<punctual_certificate> certificate(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_certificate>(punctual_distance_query_certificate, this, workspace.get());
  }
  /** Writes up to `capacity` boxes; how many there are. */
  Result<std::size_t> open_boxes(const Workspace &workspace, punctual_aabb *boxes,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_distance_query_open_boxes, this, workspace.get(), boxes, capacity);
  }
};

/** Until when is a motion free? The fields of punctual_motion_query are public; the trees must outlive it. */
struct MotionQuery : punctual_motion_query {
  MotionQuery(const Tree &tree_a, const Tree &tree_b, const punctual_motion &motion_of_b) noexcept
      : punctual_motion_query(punctual_motion_query_new(tree_a.get(), tree_b.get(), motion_of_b)) {}
  MotionQuery(const Tree &&, const Tree &, const punctual_motion &) = delete;
  MotionQuery(const Tree &, const Tree &&, const punctual_motion &) = delete;
  MotionQuery(const Tree &&, const Tree &&, const punctual_motion &) = delete;

  Result<punctual_passage> run(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                               const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_passage>(punctual_motion_query_run, this, workspace.get(),
                                            memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_passage> resume(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                                  const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_passage>(punctual_motion_query_resume, this, workspace.get(),
                                            memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_quantiles> predict(const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_quantiles>(punctual_motion_query_predict, this, memory ? memory->get() : nullptr);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace, const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_remaining>(punctual_motion_query_remaining, this, workspace.get(),
                                              memory ? memory->get() : nullptr);
  }
  Result<punctual_certificate> certificate(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_certificate>(punctual_motion_query_certificate, this, workspace.get());
  }
  /** Writes up to `capacity` boxes; how many there are. */
  Result<std::size_t> open_boxes(const Workspace &workspace, punctual_aabb *boxes,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_motion_query_open_boxes, this, workspace.get(), boxes, capacity);
  }
};

/** What keeps two solids apart? The fields of punctual_manifold_query are public; the trees must outlive it. */
struct ManifoldQuery : punctual_manifold_query {
  ManifoldQuery(const Tree &tree_a, const Tree &tree_b, const punctual_pose &pose_of_b) noexcept
      : punctual_manifold_query(punctual_manifold_query_new(tree_a.get(), tree_b.get(), pose_of_b)) {}
  ManifoldQuery(const Tree &&, const Tree &, const punctual_pose &) = delete;
  ManifoldQuery(const Tree &, const Tree &&, const punctual_pose &) = delete;
  ManifoldQuery(const Tree &&, const Tree &&, const punctual_pose &) = delete;

  Result<punctual_manifolds> run(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                                 const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_manifolds>(punctual_manifold_query_run, this, workspace.get(),
                                              memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_manifolds> resume(Workspace &workspace, punctual_budget budget, Memory *memory = nullptr,
                                    const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_manifolds>(punctual_manifold_query_resume, this, workspace.get(),
                                              memory ? memory->get() : nullptr, budget, clock);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace, const Memory *memory = nullptr) const noexcept {
    return detail::filled<punctual_remaining>(punctual_manifold_query_remaining, this, workspace.get(),
                                              memory ? memory->get() : nullptr);
  }
};

/** Where do they meet or come close? The fields of punctual_contact_query are public; the trees must outlive it. */
struct ContactQuery : punctual_contact_query {
  ContactQuery(const Tree &tree_a, const Tree &tree_b, const punctual_pose &pose_of_b) noexcept
      : punctual_contact_query(punctual_contact_query_new(tree_a.get(), tree_b.get(), pose_of_b)) {}
  ContactQuery(const Tree &&, const Tree &, const punctual_pose &) = delete;
  ContactQuery(const Tree &, const Tree &&, const punctual_pose &) = delete;
  ContactQuery(const Tree &&, const Tree &&, const punctual_pose &) = delete;

  Result<punctual_contacts> run(Workspace &workspace, punctual_budget budget,
                                const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_contacts>(punctual_contact_query_run, this, workspace.get(), budget, clock);
  }
  Result<punctual_contacts> resume(Workspace &workspace, punctual_budget budget,
                                   const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_contacts>(punctual_contact_query_resume, this, workspace.get(), budget, clock);
  }
  /** Which way the two triangles of a contact face. */
  Result<punctual_face_normals> face_normals(punctual_triangle_pair triangles) const noexcept {
    return detail::filled<punctual_face_normals>(punctual_contact_face_normals, this, triangles);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_remaining>(punctual_contact_query_remaining, this, workspace.get());
  }
  Result<punctual_certificate> certificate(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_certificate>(punctual_contact_query_certificate, this, workspace.get());
  }
  /** Writes up to `capacity` boxes; how many there are. */
  Result<std::size_t> open_boxes(const Workspace &workspace, punctual_aabb *boxes,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_contact_query_open_boxes, this, workspace.get(), boxes, capacity);
  }
};

/** Which points of a cloud are near? The fields of punctual_near_points_query are public; the trees must outlive it. */
struct NearPointsQuery : punctual_near_points_query {
  NearPointsQuery(const Tree &cloud, const Tree &other, const punctual_pose &other_in_cloud, double within = 0) noexcept
      : punctual_near_points_query(punctual_near_points_query_new(cloud.get(), other.get(), other_in_cloud)) {
    distance = within;
  }
  NearPointsQuery(const Tree &&, const Tree &, const punctual_pose &, double = 0) = delete;
  NearPointsQuery(const Tree &, const Tree &&, const punctual_pose &, double = 0) = delete;
  NearPointsQuery(const Tree &&, const Tree &&, const punctual_pose &, double = 0) = delete;

  Result<punctual_near_points> run(Workspace &workspace, punctual_budget budget,
                                   const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_near_points>(punctual_near_points_query_run, this, workspace.get(), budget, clock);
  }
  Result<punctual_near_points> resume(Workspace &workspace, punctual_budget budget,
                                      const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_near_points>(punctual_near_points_query_resume, this, workspace.get(), budget,
                                                clock);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_remaining>(punctual_near_points_query_remaining, this, workspace.get());
  }
  Result<punctual_certificate> certificate(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_certificate>(punctual_near_points_query_certificate, this, workspace.get());
  }
  /** Writes up to `capacity` boxes; how many there are. */
  Result<std::size_t> open_boxes(const Workspace &workspace, punctual_aabb *boxes,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_near_points_query_open_boxes, this, workspace.get(), boxes, capacity);
  }
};

/** The buffers of PenetrationQuery. */
class PenetrationWorkspace
    : public detail::Handle<punctual_penetration_workspace, punctual_penetration_workspace_free> {
public:
  using Handle::Handle;

  static Result<PenetrationWorkspace> make() noexcept {
    return detail::owned<PenetrationWorkspace, punctual_penetration_workspace>(punctual_penetration_workspace_new);
  }
};

/** How deep, and which way out? The fields of punctual_penetration_query are public; the trees must outlive it. */
struct PenetrationQuery : punctual_penetration_query {
  PenetrationQuery(const Tree &tree_a, const Tree &tree_b, const punctual_pose &pose_of_b) noexcept
      : punctual_penetration_query(punctual_penetration_query_new(tree_a.get(), tree_b.get(), pose_of_b)) {}
  PenetrationQuery(const Tree &&, const Tree &, const punctual_pose &) = delete;
  PenetrationQuery(const Tree &, const Tree &&, const punctual_pose &) = delete;
  PenetrationQuery(const Tree &&, const Tree &&, const punctual_pose &) = delete;

  Result<punctual_penetration> run(PenetrationWorkspace &workspace, punctual_budget budget,
                                   const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_penetration>(punctual_penetration_query_run, this, workspace.get(), budget, clock);
  }
  Result<punctual_penetration> resume(PenetrationWorkspace &workspace, punctual_budget budget,
                                      const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_penetration>(punctual_penetration_query_resume, this, workspace.get(), budget,
                                                clock);
  }
};

/** What does a ray hit? The fields of punctual_ray_query are public; the tree must outlive it. */
struct RayQuery : punctual_ray_query {
  RayQuery(const Tree &of, const punctual_ray &along) noexcept
      : punctual_ray_query(punctual_ray_query_new(of.get(), along)) {}
  RayQuery(const Tree &&, const punctual_ray &) = delete;

  Result<punctual_ray_cast> run(Workspace &workspace, punctual_budget budget,
                                const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_ray_cast>(punctual_ray_query_run, this, workspace.get(), budget, clock);
  }
  Result<punctual_ray_cast> resume(Workspace &workspace, punctual_budget budget,
                                   const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_ray_cast>(punctual_ray_query_resume, this, workspace.get(), budget, clock);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_remaining>(punctual_ray_query_remaining, this, workspace.get());
  }
};

/** What does each of many rays hit? The fields of punctual_ray_batch are public; the tree and the rays must outlive it. */
struct RayBatch : punctual_ray_batch {
  RayBatch(const Tree &of, const punctual_ray *along, std::size_t ray_count) noexcept
      : punctual_ray_batch(punctual_ray_batch_new(of.get(), along, ray_count)) {}
  RayBatch(const Tree &&, const punctual_ray *, std::size_t) = delete;

  /** `hits` has room for all rays; those of the rays that are done are written. */
  Result<punctual_ray_batch_outcome> run(Workspace &workspace, punctual_budget budget, punctual_ray_hit *hits,
                                         const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_ray_batch_outcome>(punctual_ray_batch_run, this, workspace.get(), budget, clock,
                                                      hits);
  }
  Result<punctual_ray_batch_outcome> resume(Workspace &workspace, punctual_budget budget, punctual_ray_hit *hits,
                                            const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_ray_batch_outcome>(punctual_ray_batch_resume, this, workspace.get(), budget, clock,
                                                      hits);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_remaining>(punctual_ray_batch_remaining, this, workspace.get());
  }
};

/** Which of many points are inside a solid? Distances too if `measures` is set. The tree and the points must outlive it. */
struct Points {
  const Tree &tree;
  const punctual_point *points;
  std::size_t count;
  bool measures;

  Points(const Tree &of, const punctual_point *where, std::size_t point_count, bool with_distances = false) noexcept
      : tree(of), points(where), count(point_count), measures(with_distances) {}
  Points(const Tree &&, const punctual_point *, std::size_t, bool = false) = delete;

  /** `bounds` has room for all points; those of the points that are done are written. */
  Result<punctual_points_outcome> run(Workspace &workspace, punctual_budget budget, punctual_point_bounds *bounds,
                                      const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_points_outcome>(punctual_points_run, tree.get(), points, count, measures ? 1U : 0U,
                                                   workspace.get(), budget, clock, bounds);
  }
  Result<punctual_points_outcome> resume(Workspace &workspace, punctual_budget budget, punctual_point_bounds *bounds,
                                         const punctual_clock *clock = nullptr) const noexcept {
    return detail::filled<punctual_points_outcome>(punctual_points_resume, tree.get(), points, count,
                                                   measures ? 1U : 0U, workspace.get(), budget, clock, bounds);
  }
  Result<punctual_remaining> remaining(const Workspace &workspace) const noexcept {
    return detail::filled<punctual_remaining>(punctual_points_remaining, tree.get(), points, count, measures ? 1U : 0U,
                                              workspace.get());
  }
};

/** Which body does a ray hit? The fields of punctual_scene_ray are public. */
struct SceneRay : punctual_scene_ray {
  explicit SceneRay(const punctual_ray &along) noexcept : punctual_scene_ray(punctual_scene_ray_new(along)) {}
};

/** What does a shape meet? The fields of punctual_scene_shape are public; the tree must be there until it is asked about. */
struct SceneShape : punctual_scene_shape {
  SceneShape(const Tree &shape, const punctual_motion &way) noexcept
      : punctual_scene_shape(punctual_scene_shape_new(shape.get(), way)) {}
  SceneShape(const Tree &&, const punctual_motion &) = delete;
  /** A point. */
  explicit SceneShape(const punctual_motion &way) noexcept
      : punctual_scene_shape(punctual_scene_shape_new(nullptr, way)) {}
};

/** A body to be inserted. The fields of punctual_body are public; the tree must be there until then. */
struct Body : punctual_body {
  Body(const Tree &shape, const punctual_pose &place) noexcept
      : punctual_body(punctual_body_new(shape.get(), place)) {}
  Body(const Tree &&, const punctual_pose &) = delete;
};

class Scene : public detail::Handle<punctual_scene, punctual_scene_free> {
public:
  using Handle::Handle;

  static Result<Scene> make(punctual_mode mode = PUNCTUAL_MODE_ANY,
                            punctual_reach reach = PUNCTUAL_REACH_HERE) noexcept {
    return detail::owned<Scene, punctual_scene>(punctual_scene_new, mode, reach);
  }

  [[nodiscard]] punctual_status use_threads(std::size_t threads) noexcept {
    return punctual_scene_use_threads(get(), threads);
  }
  [[nodiscard]] punctual_status reserve(std::size_t bodies, std::size_t pairs) noexcept {
    return punctual_scene_reserve(get(), bodies, pairs);
  }
  Result<punctual_body_id> insert(const punctual_body &body) noexcept {
    return detail::filled<punctual_body_id>(punctual_scene_insert, get(), &body);
  }
  [[nodiscard]] punctual_status remove(punctual_body_id id) noexcept { return punctual_scene_remove(get(), id); }
  Result<punctual_body> body(punctual_body_id id) const noexcept {
    return detail::filled<punctual_body>(punctual_scene_body, get(), id);
  }
  Result<Tree> tree(punctual_body_id id) const noexcept {
    return detail::owned<Tree, punctual_tree>(punctual_scene_tree, get(), id);
  }
  /** Writes up to `capacity` ids; how many bodies there are. */
  Result<std::size_t> bodies(punctual_body_id *ids, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_bodies, get(), ids, capacity);
  }
  [[nodiscard]] punctual_status set_pose(punctual_body_id id, const punctual_pose &pose) noexcept {
    return punctual_scene_set_pose(get(), id, pose);
  }
  [[nodiscard]] punctual_status set_tree(punctual_body_id id, const Tree &tree) noexcept {
    return punctual_scene_set_tree(get(), id, tree.get());
  }
  [[nodiscard]] punctual_status refit(punctual_body_id id, const float *vertices, std::size_t vertex_count) noexcept {
    return punctual_scene_refit_f32(get(), id, vertices, vertex_count);
  }
  [[nodiscard]] punctual_status refit(punctual_body_id id, const double *vertices,
                                      std::size_t vertex_count) noexcept {
    return punctual_scene_refit_f64(get(), id, vertices, vertex_count);
  }
  [[nodiscard]] punctual_status set_filter(punctual_body_id id, std::uint32_t groups, std::uint32_t mask) noexcept {
    return punctual_scene_set_filter(get(), id, groups, mask);
  }
  [[nodiscard]] punctual_status set_importance(punctual_body_id id, float importance) noexcept {
    return punctual_scene_set_importance(get(), id, importance);
  }
  [[nodiscard]] punctual_status set_margin(punctual_body_id id, double margin) noexcept {
    return punctual_scene_set_margin(get(), id, margin);
  }
  [[nodiscard]] punctual_status set_motion(punctual_body_id id, const punctual_motion &motion) noexcept {
    return punctual_scene_set_motion(get(), id, motion);
  }
  [[nodiscard]] punctual_status set_mode(punctual_mode mode) noexcept { return punctual_scene_set_mode(get(), mode); }
  [[nodiscard]] punctual_status set_reach(punctual_reach reach) noexcept {
    return punctual_scene_set_reach(get(), reach);
  }
  [[nodiscard]] punctual_status set_max_pairs(std::size_t pairs) noexcept {
    return punctual_scene_set_max_pairs(get(), pairs);
  }
  [[nodiscard]] punctual_status track_contacts() noexcept { return punctual_scene_track_contacts(get()); }
  [[nodiscard]] punctual_status measure(punctual_body_id x, punctual_body_id y, double tolerance) noexcept {
    return punctual_scene_measure(get(), x, y, tolerance);
  }
  [[nodiscard]] punctual_status stop_measuring(punctual_body_id x, punctual_body_id y) noexcept {
    return punctual_scene_stop_measuring(get(), x, y);
  }
  /** Bodies that move as one; the name of the compound. */
  Result<std::uint64_t> insert_compound(const punctual_pose &pose, const punctual_body *parts,
                                        std::size_t part_count) noexcept {
    return detail::filled<std::uint64_t>(punctual_scene_insert_compound, get(), pose, parts, part_count);
  }
  /** Writes up to `capacity` ids; how many parts there are. */
  Result<std::size_t> parts(std::uint64_t compound, punctual_body_id *ids, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_parts, get(), compound, ids, capacity);
  }
  /** Empty if the body is no part of a compound. */
  Result<std::optional<std::uint64_t>> compound_of(punctual_body_id id) const noexcept {
    std::uint64_t compound = 0;
    bool is_part = false;
    punctual_status status = punctual_scene_compound_of(get(), id, &compound, &is_part);
    if (status != PUNCTUAL_STATUS_OK)
      return status;
    return is_part ? std::optional(compound) : std::nullopt;
  }
  [[nodiscard]] punctual_status set_compound_pose(std::uint64_t compound, const punctual_pose &pose) noexcept {
    return punctual_scene_set_compound_pose(get(), compound, pose);
  }
  [[nodiscard]] punctual_status set_compound_motion(std::uint64_t compound, const punctual_motion &motion) noexcept {
    return punctual_scene_set_compound_motion(get(), compound, motion);
  }
  [[nodiscard]] punctual_status remove_compound(std::uint64_t compound) noexcept {
    return punctual_scene_remove_compound(get(), compound);
  }
  /** The least distance between two groups of bodies; the name of the question. */
  Result<std::uint64_t> measure_groups(const punctual_body_id *x, std::size_t x_count, const punctual_body_id *y,
                                       std::size_t y_count, double tolerance) noexcept {
    return detail::filled<std::uint64_t>(punctual_scene_measure_groups, get(), x, x_count, y, y_count, tolerance);
  }
  [[nodiscard]] punctual_status stop_measuring_groups(std::uint64_t id) noexcept {
    return punctual_scene_stop_measuring_groups(get(), id);
  }
  [[nodiscard]] punctual_status ignore(punctual_body_id x, punctual_body_id y, bool ignores) noexcept {
    return punctual_scene_ignore(get(), x, y, ignores);
  }
  /** The group of this name, new if there is none yet. */
  Result<std::uint64_t> group(const char *name) noexcept {
    return detail::filled<std::uint64_t>(punctual_scene_group, get(), name);
  }
  /** PUNCTUAL_NO_GROUP: out of its group. */
  [[nodiscard]] punctual_status set_group(punctual_body_id id, std::uint64_t group) noexcept {
    return punctual_scene_set_group(get(), id, group);
  }
  [[nodiscard]] punctual_status ignore_groups(std::uint64_t x, std::uint64_t y, bool ignores) noexcept {
    return punctual_scene_ignore_groups(get(), x, y, ignores);
  }
  [[nodiscard]] punctual_status find_contacts() noexcept { return punctual_scene_find_contacts(get()); }
  [[nodiscard]] punctual_status find_contacts_of(punctual_body_id x, punctual_body_id y) noexcept {
    return punctual_scene_find_contacts_of(get(), x, y);
  }
  [[nodiscard]] punctual_status find_contacts_between(std::uint32_t groups, std::uint32_t mask) noexcept {
    return punctual_scene_find_contacts_between(get(), groups, mask);
  }
  [[nodiscard]] punctual_status stop_finding_contacts_between(std::uint32_t groups, std::uint32_t mask) noexcept {
    return punctual_scene_stop_finding_contacts_between(get(), groups, mask);
  }
  [[nodiscard]] punctual_status stop_finding_contacts_of(punctual_body_id x, punctual_body_id y) noexcept {
    return punctual_scene_stop_finding_contacts_of(get(), x, y);
  }
  [[nodiscard]] punctual_status set_look_ahead(double length) noexcept {
    return punctual_scene_set_look_ahead(get(), length);
  }
  Result<double> may_move(punctual_body_id id, double stride, double sink) noexcept {
    return detail::filled<double>(punctual_scene_may_move, get(), id, stride, sink);
  }
  [[nodiscard]] punctual_status set_question_importance(punctual_pair_question question, float importance) noexcept {
    return punctual_scene_set_question_importance(get(), question, importance);
  }
  Result<punctual_report> detect(punctual_budget budget, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_report>(punctual_scene_detect, get(), budget, clock);
  }
  /** Writes up to `capacity` pairs of the last frame; how many there are. */
  Result<std::size_t> pairs(punctual_pair_report *pairs, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_pairs, get(), pairs, sizeof *pairs, capacity);
  }
  /** Whether the last frame knew all bodies that this one may meet. */
  Result<bool> partners_known(punctual_body_id id) const noexcept {
    return detail::filled<bool>(punctual_scene_partners_known, get(), id);
  }
  /** What it has learned of its probabilities. */
  Result<punctual_calibration> calibration() const noexcept {
    return detail::filled<punctual_calibration>(punctual_scene_calibration, get());
  }
  [[nodiscard]] punctual_status set_calibration(const punctual_calibration &calibration) noexcept {
    return punctual_scene_set_calibration(get(), &calibration);
  }
  Result<punctual_report> report() const noexcept {
    return detail::filled<punctual_report>(punctual_scene_report, get());
  }
  /** Empty if the boxes of the two are apart or they may not meet. */
  Result<std::optional<punctual_pair_report>> pair(punctual_body_id x, punctual_body_id y) const noexcept {
    punctual_pair_report pair{};
    bool listed = false;
    punctual_status status = punctual_scene_pair(get(), x, y, &pair, sizeof pair, &listed);
    if (status != PUNCTUAL_STATUS_OK)
      return status;
    return listed ? std::optional(pair) : std::nullopt;
  }
  Result<punctual_pair_certificate> certificate(punctual_body_id x, punctual_body_id y) const noexcept {
    return detail::filled<punctual_pair_certificate>(punctual_scene_certificate, get(), x, y);
  }
  /** Writes up to `capacity` contacts of the last frame; how many there are. */
  Result<std::size_t> contacts(punctual_body_contact *contacts, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_contacts, get(), contacts, sizeof *contacts, capacity);
  }
  /** The same of the distances asked for. */
  Result<std::size_t> distances(punctual_pair_distance *distances, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_distances, get(), distances, sizeof *distances, capacity);
  }
  /** The same of the distances of groups. */
  Result<std::size_t> group_distances(punctual_group_distance *distances, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_group_distances, get(), distances, sizeof *distances,
                                       capacity);
  }
  /** Writes up to `capacity` places where two bodies touch; what is known of all. */
  Result<punctual_contact_points> contact_points(punctual_body_id x, punctual_body_id y,
                                                 punctual_contact_point *points,
                                                 std::size_t capacity) const noexcept {
    return detail::filled<punctual_contact_points>(punctual_scene_contact_points, get(), x, y, points,
                                                    sizeof *points, capacity);
  }
  /** The same of the pairs in motion. */
  Result<std::size_t> passages(punctual_pair_passage *passages, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_passages, get(), passages, sizeof *passages, capacity);
  }
  Result<punctual_scene_ray_cast> cast(const punctual_scene_ray &ray, punctual_budget budget,
                                       const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_scene_ray_cast>(punctual_scene_cast, get(), &ray, budget, clock);
  }
  /** Writes an answer for each of `count` rays; how many of them are done. */
  Result<std::size_t> cast_rays(const punctual_scene_ray *rays, std::size_t count, punctual_scene_ray_cast *casts,
                                punctual_budget budget, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<std::size_t>(punctual_scene_cast_rays, get(), rays, count, budget, clock, casts,
                                       sizeof *casts);
  }
  Result<punctual_shape_cast> cast_shape(const punctual_scene_shape &shape, punctual_budget budget,
                                         const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_shape_cast>(punctual_scene_cast_shape, get(), &shape, budget, clock);
  }
  Result<punctual_closest_body> closest(const punctual_scene_shape &shape, double within, punctual_budget budget,
                                        const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_closest_body>(punctual_scene_closest, get(), &shape, within, budget, clock);
  }
  /** Writes up to so many bodies that meet the shape, and that were not decided. */
  Result<punctual_overlap> overlap(const punctual_scene_shape &shape, punctual_mode mode, punctual_body_overlap *met,
                                   std::size_t met_capacity, punctual_body_id *undecided,
                                   std::size_t undecided_capacity, punctual_budget budget,
                                   const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_overlap>(punctual_scene_overlap, get(), &shape, static_cast<std::uint32_t>(mode),
                                            budget, clock, met, sizeof *met, met_capacity, undecided,
                                            undecided_capacity);
  }
  /** Writes up to `capacity` hits of the last cast for all; how many there are. */
  Result<std::size_t> ray_hits(punctual_body_hit *hits, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_scene_ray_hits, get(), hits, capacity);
  }
};

/** A motion of all joints: polynomials of time, piece after piece. */
class Trajectory : public detail::Handle<punctual_trajectory, punctual_trajectory_free> {
public:
  using Handle::Handle;

  static Result<Trajectory> make() noexcept {
    return detail::owned<Trajectory, punctual_trajectory>(punctual_trajectory_new);
  }

  /** Row `k` of `coefficients` has those of the `k`-th power of the time, one for each joint. */
  [[nodiscard]] punctual_status push(double duration, const double *coefficients, std::size_t powers,
                                     std::size_t joints) noexcept {
    return punctual_trajectory_push(get(), duration, coefficients, powers, joints);
  }
  Result<double> seconds() const noexcept { return detail::filled<double>(punctual_trajectory_seconds, get()); }
  /** Writes up to `capacity` joint values; how many there are. */
  Result<std::size_t> at(double time, double *values, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_trajectory_at, get(), time, values, capacity);
  }
  [[nodiscard]] punctual_status clear() noexcept { return punctual_trajectory_clear(get()); }
};

/** A robot among obstacles. A configuration is an array with as many values as `joints` tells. */
class Robot : public detail::Handle<punctual_robot, punctual_robot_free> {
public:
  using Handle::Handle;

  /** `srdf` and `packages` may be null. */
  static Result<Robot> from_urdf(const char *urdf, const char *srdf = nullptr, const char *packages = nullptr,
                                 bool solids = false) noexcept {
    return detail::owned<Robot, punctual_robot>(punctual_robot_from_urdf, urdf, srdf, packages, solids ? 1U : 0U);
  }

  /** Writes up to `capacity` bytes with a zero byte at the end; how long the name is without it. */
  Result<std::size_t> joint_name(std::size_t joint, char *name, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_robot_joint_name, get(), joint, name, capacity);
  }
  Result<std::size_t> link_name(std::size_t link, char *name, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_robot_link_name, get(), link, name, capacity);
  }
  [[nodiscard]] punctual_status joint_limits(std::size_t joint, double &lower, double &upper) const noexcept {
    return punctual_robot_joint_limits(get(), joint, &lower, &upper);
  }
  /** Writes up to `capacity` poses; how many links there are. */
  Result<std::size_t> link_poses(const double *values, std::size_t joints, punctual_pose *poses,
                                 std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_robot_link_poses, get(), values, joints, poses, capacity);
  }
  Result<std::size_t> joints() const noexcept { return detail::filled<std::size_t>(punctual_robot_joints, get()); }
  /** Writes up to `capacity` bytes with a zero byte at the end; how long the name is without it. */
  Result<std::size_t> shape_name(std::uint32_t shape, char *name, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_robot_shape_name, get(), shape, name, capacity);
  }
  /** Writes up to `capacity` bytes with a zero byte at the end; how long the notices are without it. */
  Result<std::size_t> notices(char *text, std::size_t capacity) const noexcept {
    return detail::filled<std::size_t>(punctual_robot_notices, get(), text, capacity);
  }
  /** An obstacle in the world, or one that moves with `link`; it may touch the links of `may_touch`. */
  Result<std::uint32_t> add(const char *name, const Tree &tree, const punctual_pose &pose, const char *link = nullptr,
                            std::initializer_list<const char *> may_touch = {}) noexcept {
    return detail::filled<std::uint32_t>(punctual_robot_add, get(), name, tree.get(), pose, link, may_touch.begin(),
                                         may_touch.size());
  }
  [[nodiscard]] punctual_status move(std::uint32_t shape, const punctual_pose &pose) noexcept {
    return punctual_robot_move(get(), shape, pose);
  }
  [[nodiscard]] punctual_status remove(std::uint32_t shape) noexcept { return punctual_robot_remove(get(), shape); }
  /** An obstacle in the world that moves by itself, each of its points within a reach that grows. */
  [[nodiscard]] punctual_status move_along(std::uint32_t shape, const punctual_pose &pose, const punctual_point &linear,
                                           const punctual_point &angular = {}, double reach = 0,
                                           double reach_speed = 0) noexcept {
    return punctual_robot_move_along(get(), shape, pose, linear, angular, reach, reach_speed);
  }
  /** Whether two links or obstacles may touch, and are not checked. */
  [[nodiscard]] punctual_status allow(const char *x, const char *y, bool may_touch = true) noexcept {
    return punctual_robot_allow(get(), x, y, may_touch ? 1U : 0U);
  }
  /** Of all pairs, those of a name, or of two. */
  [[nodiscard]] punctual_status set_margin(double margin, const char *name = nullptr,
                                           const char *other = nullptr) noexcept {
    return punctual_robot_set_margin(get(), margin, name, other, 0U);
  }
  /** Of a link and obstacles in the world. */
  [[nodiscard]] punctual_status set_padding(double margin, const char *link) noexcept {
    return punctual_robot_set_margin(get(), margin, link, nullptr, 1U);
  }
  /** Writes up to `capacity` pairs, and `joints` gradients of each unless `gradients` is null. */
  Result<punctual_robot_near> near_pairs(const double *values, std::size_t joints, double within, double tolerance,
                                         punctual_budget budget, punctual_robot_near_pair *pairs, double *gradients,
                                         std::size_t capacity, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_near>(punctual_robot_near_pairs, get(), values, joints, within, tolerance,
                                               budget, clock, pairs, sizeof *pairs, gradients, capacity);
  }

  Result<punctual_robot_collision> collide(const double *values, std::size_t joints, punctual_budget budget,
                                           const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_collision>(punctual_robot_collide, get(), values, joints, budget, clock);
  }
  /** Writes up to `capacity` pairs of numbers, and how many there are to `count`. */
  Result<punctual_robot_collision> collide_all(const double *values, std::size_t joints, punctual_budget budget,
                                               std::uint32_t *shapes, std::size_t capacity, std::size_t &count,
                                               const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_collision>(punctual_robot_collide_all, get(), values, joints, budget, clock,
                                                    shapes, capacity, &count);
  }
  Result<punctual_robot_clearance> measure(const double *values, std::size_t joints, double tolerance,
                                           punctual_budget budget, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_clearance>(punctual_robot_measure, get(), values, joints, tolerance, budget,
                                                    clock);
  }
  Result<punctual_robot_motion> edge(const double *from, const double *to, std::size_t joints, bool first,
                                     punctual_budget budget, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_motion>(punctual_robot_edge, get(), from, to, joints, first ? 1U : 0U, budget,
                                                 clock);
  }
  /** The lines between `count` configurations. */
  Result<punctual_robot_motion> path(const double *knots, std::size_t count, std::size_t joints, bool first,
                                     punctual_budget budget, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_motion>(punctual_robot_path, get(), knots, count, joints, first ? 1U : 0U,
                                                 budget, clock);
  }
  Result<punctual_robot_motion> follow(const Trajectory &trajectory, bool first, punctual_budget budget,
                                       const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_motion>(punctual_robot_follow, get(), trajectory.get(), first ? 1U : 0U,
                                                 budget, clock);
  }
  /** The last edge or trajectory. */
  Result<punctual_robot_motion> resume_edge(punctual_budget budget, const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_motion>(punctual_robot_edge_resume, get(), budget, clock);
  }
  Result<punctual_robot_motion> horizon(const double *values, const double *velocity, std::size_t joints,
                                        double seconds, punctual_budget budget,
                                        const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_robot_motion>(punctual_robot_horizon, get(), values, velocity, joints, seconds,
                                                 budget, clock);
  }
  static Result<double> braking_time(const double *velocity, const double *decelerations,
                                     std::size_t joints) noexcept {
    return detail::filled<double>(punctual_robot_braking_time, velocity, decelerations, joints);
  }
  static double safe_speed(double free_until, double cycle, double braking) noexcept {
    return punctual_robot_safe_speed(free_until, cycle, braking);
  }
};

/** A controller that follows a plan no faster than is proven, from cycle to cycle. */
class Horizon : public detail::Handle<punctual_horizon, punctual_horizon_free> {
public:
  using Handle::Handle;

  /** Both in seconds: see Robot::braking_time. */
  static Result<Horizon> make(double cycle, double braking) noexcept {
    return detail::owned<Horizon, punctual_horizon>(punctual_horizon_new, cycle, braking);
  }

  /** The speed of the cycle that begins now. `plan` is a new one, or null. */
  Result<punctual_ahead> step(Robot &robot, const Trajectory *plan, punctual_budget budget,
                              const punctual_clock *clock = nullptr) noexcept {
    return detail::filled<punctual_ahead>(punctual_horizon_step, get(), robot.get(), plan ? plan->get() : nullptr,
                                          budget, clock);
  }
};

} // namespace punctual

#endif // PUNCTUAL_HPP

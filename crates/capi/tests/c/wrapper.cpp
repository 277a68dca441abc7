// What punctual.hpp promises about its types, as far as a compiler can tell.

#include <punctual.hpp>

#include <type_traits>

namespace {

template <class Handle> constexpr bool is_owner = std::is_nothrow_move_constructible_v<Handle> &&
                                                  std::is_nothrow_move_assignable_v<Handle> &&
                                                  !std::is_copy_constructible_v<Handle> && !std::is_copy_assignable_v<Handle> &&
                                                  sizeof(Handle) == sizeof(void *);
static_assert(is_owner<punctual::Mesh> && is_owner<punctual::Tree> && is_owner<punctual::Workspace> &&
              is_owner<punctual::Memory> && is_owner<punctual::Scene> &&
              is_owner<punctual::Robot> && is_owner<punctual::Trajectory> && is_owner<punctual::Horizon>);

// A query and a body borrow their trees, which therefore have a name of their own.
using Tree = punctual::Tree;
using Pose = punctual_pose;
static_assert(std::is_constructible_v<punctual::Query, const Tree &, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::Query, Tree, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::Query, Tree &, Tree, Pose>);
static_assert(!std::is_constructible_v<punctual::Query, Tree, Tree, Pose>);
static_assert(std::is_constructible_v<punctual::DistanceQuery, const Tree &, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::DistanceQuery, Tree, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::DistanceQuery, Tree &, Tree, Pose>);
static_assert(!std::is_constructible_v<punctual::DistanceQuery, Tree, Tree, Pose>);
static_assert(std::is_constructible_v<punctual::MotionQuery, const Tree &, Tree &, punctual_motion>);
static_assert(!std::is_constructible_v<punctual::MotionQuery, Tree, Tree &, punctual_motion>);
static_assert(!std::is_constructible_v<punctual::MotionQuery, Tree &, Tree, punctual_motion>);
static_assert(!std::is_constructible_v<punctual::MotionQuery, Tree, Tree, punctual_motion>);
static_assert(std::is_trivially_copyable_v<punctual::MotionQuery> &&
              sizeof(punctual::MotionQuery) == sizeof(punctual_motion_query));
static_assert(std::is_constructible_v<punctual::ContactQuery, const Tree &, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::ContactQuery, Tree, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::ContactQuery, Tree &, Tree, Pose>);
static_assert(!std::is_constructible_v<punctual::ContactQuery, Tree, Tree, Pose>);
static_assert(std::is_constructible_v<punctual::NearPointsQuery, const Tree &, Tree &, Pose, double>);
static_assert(!std::is_constructible_v<punctual::NearPointsQuery, Tree, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::NearPointsQuery, Tree &, Tree, Pose>);
static_assert(!std::is_constructible_v<punctual::NearPointsQuery, Tree, Tree, Pose>);
static_assert(std::is_trivially_copyable_v<punctual::NearPointsQuery> &&
              sizeof(punctual::NearPointsQuery) == sizeof(punctual_near_points_query));
static_assert(std::is_constructible_v<punctual::PenetrationQuery, const Tree &, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::PenetrationQuery, Tree, Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::PenetrationQuery, Tree &, Tree, Pose>);
static_assert(!std::is_constructible_v<punctual::PenetrationQuery, Tree, Tree, Pose>);
static_assert(std::is_constructible_v<punctual::SelfQuery, const Tree &>);
static_assert(!std::is_constructible_v<punctual::SelfQuery, Tree>);
static_assert(std::is_trivially_copyable_v<punctual::SelfQuery> &&
              sizeof(punctual::SelfQuery) == sizeof(punctual_self_query));
static_assert(std::is_constructible_v<punctual::RayQuery, const Tree &, punctual_ray>);
static_assert(!std::is_constructible_v<punctual::RayQuery, Tree, punctual_ray>);
static_assert(std::is_constructible_v<punctual::RayBatch, const Tree &, const punctual_ray *, std::size_t>);
static_assert(!std::is_constructible_v<punctual::RayBatch, Tree, const punctual_ray *, std::size_t>);
static_assert(std::is_constructible_v<punctual::Points, const Tree &, const punctual_point *, std::size_t>);
static_assert(!std::is_constructible_v<punctual::Points, Tree, const punctual_point *, std::size_t>);
static_assert(std::is_constructible_v<punctual::Body, const Tree &, Pose>);
static_assert(!std::is_constructible_v<punctual::Body, Tree, Pose>);

// Plain data: they may be copied and passed to C.
static_assert(std::is_trivially_copyable_v<punctual::Query> && sizeof(punctual::Query) == sizeof(punctual_query));
static_assert(std::is_trivially_copyable_v<punctual::DistanceQuery> &&
              sizeof(punctual::DistanceQuery) == sizeof(punctual_distance_query));
static_assert(std::is_trivially_copyable_v<punctual::ContactQuery> &&
              sizeof(punctual::ContactQuery) == sizeof(punctual_contact_query));
static_assert(std::is_trivially_copyable_v<punctual::PenetrationQuery> &&
              sizeof(punctual::PenetrationQuery) == sizeof(punctual_penetration_query));
static_assert(std::is_trivially_copyable_v<punctual::RayQuery> &&
              sizeof(punctual::RayQuery) == sizeof(punctual_ray_query));
static_assert(std::is_trivially_copyable_v<punctual::RayBatch> &&
              sizeof(punctual::RayBatch) == sizeof(punctual_ray_batch));
static_assert(std::is_trivially_copyable_v<punctual::SceneRay> &&
              sizeof(punctual::SceneRay) == sizeof(punctual_scene_ray));
static_assert(std::is_trivially_copyable_v<punctual::Body> && sizeof(punctual::Body) == sizeof(punctual_body));

} // namespace

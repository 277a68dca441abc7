// A contact checker of tesseract (0.35) that asks punctual: a tesseract::collision::DiscreteContactManager.
//
// - Spheres and capsules are exact; boxes, cones, cylinders and convex meshes are solids; meshes are surfaces. Cylinders and cones are
//   prisms around the true ones (docs/guide/shapes.md). Planes, octrees, distance fields and compound meshes are refused.
// - A distance is that of the closest points of two shapes; of shapes that meet it is the shortest push that was found, below 0. For
//   spheres and capsules that may be 1 % more than the shortest one.
// - A budget for each pair of shapes may be set. A pair that it leaves open counts with the least distance that is not yet excluded: a
//   contact may be told that is none, and none is missed.

#ifndef PUNCTUAL_TESSERACT_CONTACT_MANAGER_HPP
#define PUNCTUAL_TESSERACT_CONTACT_MANAGER_HPP

#include <punctual.hpp>
#include <tesseract/collision/common.h>
#include <tesseract/collision/discrete_contact_manager.h>
#include <tesseract/common/collision_margin_data.h>
#include <tesseract/common/contact_allowed_validator.h>
#include <tesseract/geometry/geometries.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

namespace punctual_tesseract {

using tesseract::common::LinkId;
using Shapes = tesseract::collision::CollisionShapesConst;
using Poses = tesseract::common::VectorIsometry3d;

/** A value, or an exception with the text of the failure. */
template <class T> T value(punctual::Result<T> result) {
  if (!result)
    throw std::runtime_error(punctual::last_error());
  return std::move(result).value();
}

inline punctual_pose pose_of(const Eigen::Isometry3d &pose) {
  punctual_pose found;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++)
      found.m[4 * row + column] = pose(row, column);
  return found;
}

inline Eigen::Vector3d vector_of(const punctual_point &point) { return {point.x, point.y, point.z}; }

/** The triangles of a mesh, whose polygons are convex. */
inline punctual::Tree tree_of(const tesseract::geometry::PolygonMesh &mesh, bool is_solid) {
  std::vector<double> vertices;
  for (const Eigen::Vector3d &vertex : *mesh.getVertices())
    vertices.insert(vertices.end(), vertex.data(), vertex.data() + 3);
  std::vector<std::uint32_t> triangles;
  const Eigen::VectorXi &faces = *mesh.getFaces();
  for (Eigen::Index at = 0; at < faces.size(); at += faces[at] + 1)
    for (int corner = 2; corner < faces[at]; corner++)
      for (int i : {1, corner, corner + 1})
        triangles.push_back(static_cast<std::uint32_t>(faces[at + i]));
  punctual_build_options options = punctual_build_options_default();
  options.solid = is_solid ? PUNCTUAL_SOLID_FLIP : PUNCTUAL_SOLID_NO;
  const std::size_t count = triangles.size() / 3;
  return value(punctual::Tree::build(
      value(punctual::Mesh::make(vertices.data(), vertices.size() / 3, triangles.data(), count)), options));
}

inline punctual::Tree tree_of(const tesseract::geometry::Geometry &shape) {
  using namespace tesseract::geometry;
  switch (shape.getType()) {
  case GeometryType::SPHERE:
    return value(punctual::Tree::ball(static_cast<const Sphere &>(shape).getRadius()));
  case GeometryType::BOX: {
    const auto &box = static_cast<const Box &>(shape);
    return value(punctual::Tree::box(box.getX(), box.getY(), box.getZ()));
  }
  case GeometryType::CYLINDER: {
    const auto &cylinder = static_cast<const Cylinder &>(shape);
    return value(punctual::Tree::cylinder(cylinder.getRadius(), cylinder.getLength()));
  }
  case GeometryType::CAPSULE: {
    const auto &capsule = static_cast<const Capsule &>(shape);
    return value(punctual::Tree::capsule(capsule.getRadius(), capsule.getLength()));
  }
  case GeometryType::CONE: {
    const auto &cone = static_cast<const Cone &>(shape);
    return value(punctual::Tree::cone(cone.getRadius(), cone.getLength()));
  }
  case GeometryType::CONVEX_MESH:
  case GeometryType::MESH:
  case GeometryType::POLYGON_MESH:
    return tree_of(static_cast<const PolygonMesh &>(shape), shape.getType() == GeometryType::CONVEX_MESH);
  default:
    throw std::runtime_error("a shape of the kind " + GeometryTypeStrings[static_cast<std::size_t>(shape.getType())] +
                             " is not known");
  }
}

class ContactManager : public tesseract::collision::DiscreteContactManager {
public:
  /** `budget` is that of each pair of shapes. */
  explicit ContactManager(std::string name = "PunctualContactManager",
                          punctual_budget budget = punctual_budget_unlimited())
      : name_(std::move(name)), budget_(budget) {}

  std::string getName() const override { return name_; }

  /** Trees are shared, workspaces are not. */
  UPtr clone() const override {
    auto copy = std::make_unique<ContactManager>(name_, budget_);
    copy->objects_ = objects_;
    copy->ids_ = ids_;
    copy->active_ = active_;
    copy->margins_ = margins_;
    copy->validator_ = validator_;
    return copy;
  }

  bool addCollisionObject(const LinkId &id, const int &mask_id, const Shapes &shapes, const Poses &shape_poses,
                          bool enabled = true) override {
    if (shapes.empty() || shapes.size() != shape_poses.size())
      return false;
    removeCollisionObject(id);
    Object object{id, mask_id, shapes, shape_poses, {}, Eigen::Isometry3d::Identity(), enabled};
    for (const auto &shape : shapes)
      object.trees.push_back(std::make_shared<punctual::Tree>(tree_of(*shape)));
    objects_.push_back(std::move(object));
    ids_.push_back(id);
    return true;
  }

  const Shapes &getCollisionObjectGeometries(const LinkId &id) const override { return at(id).shapes; }
  const Poses &getCollisionObjectGeometriesTransforms(const LinkId &id) const override { return at(id).shape_poses; }
  bool hasCollisionObject(const LinkId &id) const override { return index(id) < objects_.size(); }

  bool removeCollisionObject(const LinkId &id) override {
    const std::size_t found = index(id);
    if (found == objects_.size())
      return false;
    objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(found));
    ids_.erase(ids_.begin() + static_cast<std::ptrdiff_t>(found));
    return true;
  }

  bool enableCollisionObject(const LinkId &id) override { return enable(id, true); }
  bool disableCollisionObject(const LinkId &id) override { return enable(id, false); }
  bool isCollisionObjectEnabled(const LinkId &id) const override { return hasCollisionObject(id) && at(id).enabled; }

  using DiscreteContactManager::setCollisionObjectsTransform;
  void setCollisionObjectsTransform(const LinkId &id, const Eigen::Isometry3d &pose) override {
    const std::size_t found = index(id);
    if (found < objects_.size())
      objects_[found].pose = pose;
  }
  void setCollisionObjectsTransform(const tesseract::common::LinkIdTransformMap &transforms) override {
    for (const auto &[id, pose] : transforms)
      setCollisionObjectsTransform(id, pose);
  }
  Eigen::Isometry3d getCollisionObjectsTransform(const LinkId &id) const override { return at(id).pose; }

  const std::vector<LinkId> &getCollisionObjects() const override { return ids_; }
  using DiscreteContactManager::setActiveCollisionObjects;
  void setActiveCollisionObjects(const std::unordered_set<LinkId> &ids) override { active_ = ids; }
  const std::unordered_set<LinkId> &getActiveCollisionObjects() const override { return active_; }

  void setCollisionMarginData(tesseract::collision::CollisionMarginData margins) override { margins_ = std::move(margins); }
  const tesseract::collision::CollisionMarginData &getCollisionMarginData() const override { return margins_; }
  void setCollisionMarginPairData(const tesseract::collision::CollisionMarginPairData &margins,
                                  tesseract::collision::CollisionMarginPairOverrideType kind =
                                      tesseract::collision::CollisionMarginPairOverrideType::REPLACE) override {
    margins_.apply(margins, kind);
  }
  void setDefaultCollisionMargin(double margin) override { margins_.setDefaultCollisionMargin(margin); }
  void setCollisionMarginPair(const LinkId &a, const LinkId &b, double margin) override {
    margins_.setCollisionMargin(a, b, margin);
  }
  void incrementCollisionMargin(double increment) override { margins_.incrementMargins(increment); }

  void setContactAllowedValidator(
      std::shared_ptr<const tesseract::common::ContactAllowedValidator> validator) override {
    validator_ = std::move(validator);
  }
  std::shared_ptr<const tesseract::common::ContactAllowedValidator> getContactAllowedValidator() const override {
    return validator_;
  }

  void contactTest(tesseract::collision::ContactResultMap &found,
                   const tesseract::collision::ContactRequest &request) override {
    tesseract::collision::ContactTestData data(margins_, validator_, request, found);
    for (std::size_t j = 0; j < objects_.size(); j++)
      for (std::size_t i = 0; i < j && !data.done; i++) {
        const Object &a = objects_[i], &b = objects_[j];
        const bool moves = active_.count(a.id) + active_.count(b.id) > 0;
        if (moves && a.enabled && b.enabled && !tesseract::collision::isContactAllowed(a.id, b.id, validator_))
          test(a, b, data);
      }
  }

private:
  struct Object {
    LinkId id;
    int mask_id;
    Shapes shapes;
    Poses shape_poses;
    std::vector<std::shared_ptr<punctual::Tree>> trees;
    Eigen::Isometry3d pose;
    bool enabled;
  };

  std::size_t index(const LinkId &id) const {
    return static_cast<std::size_t>(std::find(ids_.begin(), ids_.end(), id) - ids_.begin());
  }

  const Object &at(const LinkId &id) const { return objects_.at(index(id)); }

  bool enable(const LinkId &id, bool enabled) {
    const std::size_t found = index(id);
    if (found < objects_.size())
      objects_[found].enabled = enabled;
    return found < objects_.size();
  }

  /** All shapes of two objects. */
  void test(const Object &a, const Object &b, tesseract::collision::ContactTestData &data) {
    const tesseract::common::LinkIdPair key(a.id, b.id);
    const double margin = margins_.getCollisionMargin(key);
    for (std::size_t i = 0; i < a.trees.size(); i++)
      for (std::size_t j = 0; j < b.trees.size() && !data.done; j++) {
        tesseract::collision::ContactResult contact;
        contact.link_ids = {a.id, b.id};
        contact.type_id = {a.mask_id, b.mask_id};
        contact.shape_id = {static_cast<int>(i), static_cast<int>(j)};
        contact.subshape_id = {0, 0};
        contact.transform = {a.pose, b.pose};
        const Eigen::Isometry3d place = a.pose * a.shape_poses[i];
        const Eigen::Isometry3d b_in_a = place.inverse() * (b.pose * b.shape_poses[j]);
        if (measure(*a.trees[i], *b.trees[j], b_in_a, margin, data.req.calculate_penetration, contact)) {
          contact.normal = place.linear() * contact.normal;
          for (int side : {0, 1}) {
            contact.nearest_points[side] = place * contact.nearest_points[side];
            contact.nearest_points_local[side] = contact.transform[side].inverse() * contact.nearest_points[side];
          }
          const bool is_known = data.res->find(key) != data.res->end();
          tesseract::collision::processResult(data, contact, key, margin, is_known);
        }
      }
  }

  /** Distance, points and normal in the frame of A; false if the shapes are proven to be farther apart than the margin. */
  bool measure(const punctual::Tree &a, const punctual::Tree &b, const Eigen::Isometry3d &b_in_a, double margin,
               bool with_depth, tesseract::collision::ContactResult &contact) {
    punctual::DistanceQuery query(a, b, pose_of(b_in_a));
    query.closer_than = std::max(margin, 0.0);
    if (value(query.run(workspace_, budget_)).closer == PUNCTUAL_CLOSER_NO)
      return false;
    query.closer_than = HUGE_VAL;
    const punctual_distance near = value(query.run(workspace_, budget_));
    const bool is_done = near.stop == PUNCTUAL_STOP_REASON_FINISHED;
    contact.distance = is_done ? near.high : near.low;
    if (near.has_nearest) {
      contact.nearest_points = {vector_of(near.points[0]), vector_of(near.points[1])};
      contact.normal = (contact.nearest_points[1] - contact.nearest_points[0]).normalized();
    } else {
      contact.nearest_points = {b_in_a.translation(), b_in_a.translation()};
    }
    if (near.high > 0 || !with_depth)
      return true;
    punctual::PenetrationQuery depth(a, b, pose_of(b_in_a));
    depth.solid = 1;
    const punctual_penetration push = value(depth.run(depths_, budget_));
    if (push.has_push) {
      contact.distance = -push.high;
      contact.normal = vector_of(push.direction);
    }
    return true;
  }

  std::string name_;
  punctual_budget budget_;
  std::vector<Object> objects_;
  std::vector<LinkId> ids_;
  std::unordered_set<LinkId> active_;
  tesseract::collision::CollisionMarginData margins_{0.0};
  std::shared_ptr<const tesseract::common::ContactAllowedValidator> validator_;
  punctual::Workspace workspace_ = value(punctual::Workspace::make());
  punctual::PenetrationWorkspace depths_ = value(punctual::PenetrationWorkspace::make());
};

} // namespace punctual_tesseract

#endif // PUNCTUAL_TESSERACT_CONTACT_MANAGER_HPP

// The contact checker against distances that are known: a ball, a box and a mesh beside each other, apart, touching, sunk in.

#include "contact_manager.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace {

using namespace tesseract::collision;
using namespace tesseract::geometry;
using tesseract::common::LinkId;

#define CHECK(condition)                                                                                               \
  do {                                                                                                                 \
    if (!(condition)) {                                                                                                \
      std::fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                     \
      std::exit(1);                                                                                                    \
    }                                                                                                                  \
  } while (false)

Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d(Eigen::Translation3d(x, y, z)); }

/** The contacts of two links. */
ContactResultVector contacts(DiscreteContactManager &manager, ContactTestType type = ContactTestType::CLOSEST) {
  ContactResultMap map;
  manager.contactTest(map, ContactRequest(type));
  ContactResultVector all;
  map.flattenCopyResults(all);
  return all;
}

class Allow : public tesseract::common::ContactAllowedValidator {
public:
  bool operator()(const tesseract::common::LinkIdPair &) const override { return true; }
};

} // namespace

int main() {
  punctual_tesseract::ContactManager manager;
  const LinkId ball("ball"), box("box");
  const Eigen::Isometry3d turned = at(0, 0, 0) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
  CHECK(manager.addCollisionObject(box, 7, {std::make_shared<Box>(2, 2, 2)}, {turned.inverse()}));
  CHECK(manager.addCollisionObject(ball, 0, {std::make_shared<Sphere>(0.5), std::make_shared<Capsule>(0.1, 1)},
                                   {at(0, 0, 0), at(0, 0, 2)}));
  manager.setActiveCollisionObjects({ball});
  manager.setCollisionObjectsTransform(box, turned);
  manager.setDefaultCollisionMargin(0.3);

  // 0.2 beside the box, whose own pose undoes that of its shape.
  manager.setCollisionObjectsTransform(ball, at(1.7, 0.1, 0));
  auto found = contacts(manager);
  CHECK(found.size() == 1 && std::abs(found[0].distance - 0.2) < 1e-5 && found[0].type_id[0] == 7);
  CHECK((found[0].normal - Eigen::Vector3d::UnitX()).norm() < 1e-4 && found[0].shape_id[1] == 0);
  CHECK((found[0].nearest_points[1] - Eigen::Vector3d(1.2, 0.1, 0)).norm() < 1e-4);
  CHECK((found[0].nearest_points_local[1] - Eigen::Vector3d(-0.5, 0, 0)).norm() < 1e-4);
  manager.setCollisionObjectsTransform(ball, at(1.9, 0, 0));
  CHECK(contacts(manager).empty());

  // Sunk in by 0.1 and by 0.75, deep inside, and of a copy.
  for (double x : {1.4, 0.75}) {
    manager.setCollisionObjectsTransform(ball, at(x, 0, 0));
    auto copy = manager.clone();
    found = contacts(*copy);
    // A push is no shorter than the shortest one, and hardly longer.
    CHECK(found.size() == 1 && found[0].distance < x - 1.5 + 1e-9 && found[0].distance > 1.01 * (x - 1.5));
    CHECK(found[0].normal.x() > 0.99);
  }

  // Each pair of shapes; what may touch, is off, or is gone.
  manager.setCollisionObjectsTransform(ball, at(0, 0, -1.4));
  CHECK(contacts(manager, ContactTestType::ALL).size() == 2 && contacts(manager, ContactTestType::FIRST).size() == 1);
  manager.setContactAllowedValidator(std::make_shared<Allow>());
  CHECK(contacts(manager).empty());
  manager.setContactAllowedValidator(nullptr);
  CHECK(manager.disableCollisionObject(ball) && contacts(manager).empty() && manager.enableCollisionObject(ball));
  manager.setActiveCollisionObjects(std::vector<LinkId>());
  CHECK(contacts(manager).empty());

  // A mesh of a triangle and a quadrilateral: a roof over the box.
  auto vertices = std::make_shared<tesseract::common::VectorVector3d>(
      tesseract::common::VectorVector3d{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {2, 0, 0}});
  auto faces = std::make_shared<Eigen::VectorXi>(9);
  *faces << 4, 0, 1, 2, 3, 3, 1, 4, 2;
  const LinkId roof("roof");
  CHECK(manager.addCollisionObject(roof, 0, {std::make_shared<PolygonMesh>(vertices, faces)}, {at(0, 0, 0)}));
  manager.setActiveCollisionObjects({roof});
  manager.setCollisionObjectsTransform(roof, at(0, 0, 1.25));
  manager.setCollisionObjectsTransform(ball, at(9, 0, 0));
  found = contacts(manager);
  CHECK(found.size() == 1 && std::abs(found[0].distance - 0.25) < 1e-5);
  CHECK(manager.removeCollisionObject(box) && contacts(manager).empty() && !manager.hasCollisionObject(box));

  // Without work nothing is excluded: a contact is told, at distance 0.
  punctual_tesseract::ContactManager hasty("hasty", punctual_budget_work(0));
  hasty.addCollisionObject(ball, 0, {std::make_shared<Sphere>(0.5)}, {at(0, 0, 0)});
  hasty.addCollisionObject(box, 0, {std::make_shared<Box>(2, 2, 2)}, {at(9, 0, 0)});
  hasty.setActiveCollisionObjects({ball});
  found = contacts(hasty);
  CHECK(found.size() == 1 && found[0].distance <= 0);
  try {
    hasty.addCollisionObject(box, 0, {std::make_shared<Plane>(0, 0, 1, 0)}, {at(0, 0, 0)});
    CHECK(false);
  } catch (const std::runtime_error &error) {
    CHECK(std::string(error.what()) == "a shape of the kind PLANE is not known");
  }
  std::puts("as it should be");
}

// The frame loop of a game: 60 bodies over a ground that waves, one budget a frame for all collisions.
//
// First with budgets of work, which give the same figures in every run, on any number of threads, and in every language (the
// line that begins with "=": examples/c/answers.rs prints it too); then with one millisecond a frame, where every verdict is
// compared with that of a second scene that has all the time it wants. Usage: engine [frames]

#include <punctual.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

namespace {

constexpr std::size_t BODIES = 60;
constexpr std::uint64_t WORK = 400'000, LIMIT = 1'000'000; // units, nanoseconds

void must(punctual_status status) {
  if (status != PUNCTUAL_STATUS_OK) {
    std::fprintf(stderr, "%s\n", punctual::last_error());
    std::exit(1);
  }
}

/// The value, or the end of the program. An engine would hand the error on.
template <class T> T must(punctual::Result<T> result) {
  must(result.status());
  return *std::move(result);
}

/// From -1 to 1 and back, once as x grows by 1.
double swing(double x) { return 4 * std::fabs(x - std::floor(x + 0.5)) - 1; }

punctual_pose pose_of(std::size_t body, int frame) {
  double time = frame / 60.0, own = 0.618 * static_cast<double>(body);
  punctual_point place = {6 * swing(own + 0.05 * time), 6 * swing(1.7 * own - 0.04 * time), 1 + swing(own + 0.3 * time)};
  return must(punctual::pose_from_quaternion(swing(own + time), swing(2 * own), 0.5, 1, place));
}

/// The ground, waving.
class Ground {
public:
  explicit Ground(const punctual::Mesh &mesh) {
    std::size_t count = must(mesh.describe()).vertices;
    for (std::size_t i = 0; i < count; i++)
      rest_.push_back(must(mesh.vertex(i)));
    vertices_.resize(3 * count);
  }

  const std::vector<float> &at(int frame) {
    for (std::size_t i = 0; i < rest_.size(); i++) {
      auto [x, y, z] = rest_[i];
      vertices_[3 * i] = static_cast<float>(7 * x);
      vertices_[3 * i + 1] = static_cast<float>(7 * y);
      vertices_[3 * i + 2] = static_cast<float>(z + 0.2 * swing(x + frame / 120.0));
    }
    return vertices_;
  }

private:
  std::vector<punctual_point> rest_;
  std::vector<float> vertices_;
};

/// A scene and the ids of its bodies, the ground first.
struct World {
  punctual::Scene scene = must(punctual::Scene::make());
  std::vector<punctual_body_id> ids;

  World(const punctual::Tree &ground, const std::vector<punctual::Tree> &shapes) {
    punctual::Body fixed(ground, punctual::identity());
    fixed.kind = PUNCTUAL_BODY_KIND_FIXED;
    ids.push_back(must(scene.insert(fixed)));
    for (std::size_t i = 0; i < BODIES; i++) {
      punctual::Body body(shapes[i % shapes.size()], pose_of(i, 0));
      body.importance = i == 0 ? 1.0f : 0.0f; // the player
      ids.push_back(must(scene.insert(body)));
    }
  }

  /// New places for all, in place: nothing is allocated once the ground has a tree of its own.
  void move(int frame, Ground &ground) {
    const std::vector<float> &vertices = ground.at(frame);
    must(scene.refit(ids[0], vertices.data(), vertices.size() / 3));
    for (std::size_t i = 0; i < BODIES; i++)
      must(scene.set_pose(ids[i + 1], pose_of(i, frame)));
  }
};

struct Sums {
  std::uint64_t pairs = 0, decided = 0, intersecting = 0, work = 0, worst_age = 0;

  void add(const punctual_report &report) {
    pairs += report.pair_count;
    decided += report.decided;
    intersecting += report.intersecting;
    work += report.work;
    worst_age = std::max(worst_age, report.worst_age);
  }
};

} // namespace

int main(int count, char **arguments) {
  int frames = count > 1 ? std::atoi(arguments[1]) : 120;
  punctual::Mesh hills = must(punctual::Mesh::height_field(32, 7));
  Ground ground(hills);
  punctual::Tree ground_tree = must(punctual::Tree::build(hills));
  std::vector<punctual::Tree> shapes;
  shapes.push_back(must(punctual::Tree::build(must(punctual::Mesh::torus_knot(2, 3, 0.2f, 96)))));
  shapes.push_back(must(punctual::Tree::build(must(punctual::Mesh::gear(17, 4)))));
  shapes.push_back(must(punctual::Tree::build(must(punctual::Mesh::icosphere(4)))));

  Sums planned;
  World plan(ground_tree, shapes);
  must(plan.scene.use_threads(2));
  for (int frame = 0; frame < 60; frame++) {
    plan.move(frame, ground);
    planned.add(must(plan.scene.detect(punctual::work(WORK))));
  }
  std::printf("= engine: %llu pairs, %llu decided, %llu intersecting, oldest %llu, work %llu\n",
              static_cast<unsigned long long>(planned.pairs), static_cast<unsigned long long>(planned.decided),
              static_cast<unsigned long long>(planned.intersecting),
              static_cast<unsigned long long>(planned.worst_age), static_cast<unsigned long long>(planned.work));

  Sums played;
  World game(ground_tree, shapes), unhurried(ground_tree, shapes);
  std::vector<punctual_pair_report> pairs;
  int late = 0, wrong = 0;
  for (int frame = 0; frame < frames; frame++) {
    game.move(frame, ground);
    punctual_report report = must(game.scene.detect(punctual::time(LIMIT)));
    played.add(report);
    late += report.elapsed > static_cast<std::int64_t>(LIMIT);
    unhurried.move(frame, ground);
    must(unhurried.scene.detect(punctual::unlimited()));
    pairs.resize(report.pair_count);
    must(game.scene.pairs(pairs.data(), pairs.size()));
    for (punctual_pair_report &pair : pairs) {
      // The bodies of the same index and generation in the other world.
      pair.a.scene = pair.b.scene = 0;
      auto truth = must(unhurried.scene.pair(pair.a, pair.b));
      // What is not in the other report has boxes that are apart. Of a body that had no time to be placed, this one goes by
      // an earlier box.
      punctual_verdict expected = truth ? truth->verdict : PUNCTUAL_VERDICT_SEPARATED;
      wrong += pair.verdict != PUNCTUAL_VERDICT_UNDECIDED && pair.verdict != expected;
    }
  }
  std::printf("%d frames of 1 ms: %llu of %llu pairs decided, %llu intersecting; late frames: %d\n", frames,
              static_cast<unsigned long long>(played.decided), static_cast<unsigned long long>(played.pairs),
              static_cast<unsigned long long>(played.intersecting), late);
  std::printf("verdicts that were wrong: %d\n", wrong);
  return wrong != 0;
}

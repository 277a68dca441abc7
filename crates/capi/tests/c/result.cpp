// What a Result of punctual.hpp does without a value, in every build: `.ci/c` compiles this with and without NDEBUG, and with
// sanitizers. Each use that must end the process is tried in a process of its own.

#include <punctual.hpp>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#define CHECK(condition)                                                                                               \
  do {                                                                                                                 \
    if (!(condition)) {                                                                                                \
      std::fprintf(stderr, "%s:%d: not so: %s (last error: %s)\n", __FILE__, __LINE__, #condition,                     \
                   punctual::last_error());                                                                            \
      std::exit(1);                                                                                                    \
    }                                                                                                                  \
  } while (0)

namespace {

/// Whether a use ends the process with an abort.
template <class Use> bool aborts(Use use) {
  std::fflush(nullptr);
  pid_t child = fork();
  if (child == 0) {
    std::signal(SIGABRT, SIG_DFL);
    if (!std::freopen("/dev/null", "w", stderr))
      std::_Exit(2);
    use();
    std::_Exit(0);
  }
  int status = 0;
  CHECK(child > 0 && waitpid(child, &status, 0) == child);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

/// A failure of each kind of value: a handle, a struct, a number, an array.
punctual::Result<punctual::Mesh> no_mesh() { return punctual::Mesh::read("no such file.obj"); }
punctual::Result<punctual_pose> no_pose() { return punctual::pose_from_quaternion(0, 0, 0, 0, {0, 0, 0}); }
punctual::Result<std::size_t> no_count() { return punctual::Workspace().contacts(nullptr, 0); }
punctual::Result<punctual::Span<punctual_triangle_pair>> no_pairs() { return punctual::Workspace().pairs(); }

template <class Make> void fails(Make make, punctual_status status) {
  auto failure = make();
  const auto &same = failure;
  CHECK(!failure && failure.status() == status);
  CHECK(aborts([&] { (void)*failure; }));
  CHECK(aborts([&] { (void)*same; }));
  CHECK(aborts([&] { (void)*std::move(failure); }));
  CHECK(aborts([&] { (void)failure.operator->(); }));
  CHECK(aborts([&] { (void)same.operator->(); }));
  CHECK(aborts([&] { (void)failure.value(); }));
  CHECK(aborts([&] { (void)make().value(); }));
}

} // namespace

int main() {
  fails(no_mesh, PUNCTUAL_STATUS_BAD_FILE);
  fails(no_pose, PUNCTUAL_STATUS_BAD_POSE);
  fails(no_count, PUNCTUAL_STATUS_NULL);
  fails(no_pairs, PUNCTUAL_STATUS_NULL);
  CHECK(no_pose().value_or(punctual::identity()).m[0] == 1);
  CHECK(no_count().value_or(7) == 7);

  // Success without a value is none.
  punctual::Result<int> odd(PUNCTUAL_STATUS_OK);
  CHECK(!odd && odd.status() != PUNCTUAL_STATUS_OK && aborts([&] { (void)*odd; }));

  // With a value all of them are that value, and handles can be moved out.
  auto ball = punctual::Mesh::icosphere(2);
  CHECK(ball && ball.status() == PUNCTUAL_STATUS_OK && ball->get() && (*ball).get() == ball.value().get());
  punctual::Mesh mesh = *std::move(ball);
  CHECK(mesh.describe().value().triangles == 320);
  CHECK(mesh.vertex(0).value_or({9, 9, 9}).x < 2);

  // A handle that was moved from is null, which every function sees.
  punctual::Mesh other = std::move(mesh);
  CHECK(mesh.describe().status() == PUNCTUAL_STATUS_NULL);
  auto tree = punctual::Tree::build(other);
  punctual::Tree gone;
  auto workspace = punctual::Workspace::make();
  CHECK(punctual::Query(*tree, gone, punctual::identity()).run(*workspace, punctual::unlimited()).status() ==
        PUNCTUAL_STATUS_NULL);
  auto outcome = punctual::Query(*tree, *tree, punctual::identity()).run(*workspace, punctual::unlimited());
  CHECK(outcome && outcome->verdict == PUNCTUAL_VERDICT_INTERSECTING && outcome->size == sizeof(punctual_outcome));
  CHECK(punctual::sized<punctual_outcome>().size == sizeof(punctual_outcome));
  std::puts("a Result without a value ends the process");
}

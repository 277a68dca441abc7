"""Many poses in one call, many threads, the interpreter's lock."""

import signal
import threading
import time

import numpy as np
import punctual3d
import pytest
from conftest import random_poses


@pytest.mark.parametrize("options", [{}, {"mode": "all"}, {"mode": "all", "work": 3000}, {"work": 200, "prior": 0.2}])
@pytest.mark.parametrize("threads", [1, 3])
def test_a_batch_says_what_single_calls_say(ball, ring, poses, options, threads):
    batch = punctual3d.collide_batch(ball, ring, poses, threads=threads, **options)
    assert len(batch) == len(poses) and batch.offsets[-1] == len(batch.pairs)
    codes = {"intersecting": 1, "separated": 0, "undecided": -1}
    for row, pose in enumerate(poses):
        one = punctual3d.collide(ball, ring, pose, **options)
        assert codes[one.verdict] == batch.verdict[row] and one.found == batch.found[row]
        assert one.pairs.tolist() == batch.pairs[batch.offsets[row] : batch.offsets[row + 1]].tolist()
        assert (one.probability, one.recall, one.work) == (batch.probability[row], batch.recall[row], batch.work[row])
        assert tuple(batch.witness[row]) == (one.witness or (0, 0))
    if "work" in options:
        assert (batch.recall < 1).any()
    else:
        assert set(batch.verdict.tolist()) == {0, 1}


@pytest.mark.parametrize("options", [{}, {"work": 800}, {"closer_than": 0.3}, {"margins": [0.1, 0.0]}])
@pytest.mark.parametrize("threads", [1, 3])
def test_distances_of_a_batch(ball, ring, poses, options, threads):
    batch = punctual3d.distance_batch(ball, ring, poses, threads=threads, **options)
    for row, pose in enumerate(poses):
        rest = dict(options)
        limit = rest.pop("closer_than", None)
        one = (
            punctual3d.distance(ball, ring, pose, **rest)
            if limit is None
            else punctual3d.closer_than(ball, ring, limit, pose)
        )
        assert (one.low, one.high, one.work) == (batch.low[row], batch.high[row], batch.work[row])
        assert batch.closer[row] == (-1 if one.closer is None else int(one.closer))
        assert tuple(batch.triangles[row]) == (one.triangles or (0, 0))
        assert np.array_equal(
            batch.points[row], np.full((2, 3), np.nan) if one.points is None else one.points, equal_nan=True
        )


def test_memory_along_a_batch(ball, ring):
    path = np.tile(np.eye(4), (200, 1, 1))
    path[:, 0, 3] = np.linspace(0.8, 1.2, 200)
    plain = punctual3d.collide_batch(ball, ring, path)
    memory = punctual3d.Memory()
    kept = punctual3d.collide_batch(ball, ring, path, memory=memory)
    assert (kept.verdict == plain.verdict).all() and memory.last_verdict is True
    assert kept.work.sum() < plain.work.sum() / 2
    with pytest.raises(ValueError, match="threads=1"):
        punctual3d.collide_batch(ball, ring, path, memory=memory, threads=2)


def test_faults_name_the_row(ball, ring, poses):
    for change, text in [
        ((5, 0, 0, 3.0), "pose 5: matrix is off a rotation by"),
        ((7, 1, 3, np.nan), r"pose 7: entry 7 of the pose \[R|t\], row by row, is not finite"),
        ((9, 3, 3, 2.0), r"pose 9: row 3 is \[0.0, 0.0, 0.0, 2.0\], expected \[0, 0, 0, 1\]"),
    ]:
        wrong = poses.copy()
        wrong[change[:3]] = change[3]
        for batch in (punctual3d.collide_batch, punctual3d.distance_batch):
            with pytest.raises(ValueError, match=text):
                batch(ball, ring, wrong)
    with pytest.raises(ValueError, match=r"poses: shape \[2, 3, 4\], expected \(N, 4, 4\)"):
        punctual3d.collide_batch(ball, ring, np.zeros((2, 3, 4)))
    with pytest.raises(ValueError, match="threads is 0"):
        punctual3d.collide_batch(ball, ring, poses, threads=0)
    assert len(punctual3d.collide_batch(ball, ring, np.zeros((0, 4, 4)), threads=4)) == 0


def test_any_layout_of_poses(ball, ring, poses):
    said = punctual3d.collide_batch(ball, ring, poses).verdict.tolist()
    assert punctual3d.collide_batch(ball, ring, np.asfortranarray(poses)).verdict.tolist() == said
    assert punctual3d.collide_batch(ball, ring, poses.tolist()).verdict.tolist() == said
    assert punctual3d.collide_batch(ball, ring, poses[::-1]).verdict.tolist() == said[::-1]
    # One pose is a batch of one.
    for pose in (poses[3], poses[3].tolist(), poses[3].T.copy().T):
        assert punctual3d.collide_batch(ball, ring, pose) == punctual3d.collide_batch(ball, ring, poses[3:4])
        assert punctual3d.distance_batch(ball, ring, pose) == punctual3d.distance_batch(ball, ring, poses[3:4])
    assert len(punctual3d.distance_batch(ball, ring, [])) == 0


def test_a_batch_leaves_the_lock_to_others(ball, ring):
    many = random_poses(20_000, 3.0)
    done = threading.Event()
    batch = threading.Thread(target=lambda: (punctual3d.distance_batch(ball, ring, many), done.set()))
    batch.start()
    turns = 0
    while not done.is_set():
        turns += 1
        time.sleep(0.001)
    batch.join()
    assert turns > 5


@pytest.mark.parametrize("threads", [1, 2])
def test_the_user_can_end_a_batch(ball, ring, threads):
    many = np.tile(np.eye(4), (300_000, 1, 1))
    # Processes in the background of a shell begin without it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        punctual3d.distance_batch(ball, ring, many, absolute_tolerance=0.0, threads=threads)
    assert time.perf_counter() - start < 10


def test_threads_share_trees(ball, ring, poses):
    said = []
    work = lambda: said.append([bool(punctual3d.collide(ball, ring, pose)) for pose in poses])
    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(said) == 4 and all(one == said[0] for one in said)


def test_one_thread_at_a_time_uses_a_query():
    large = punctual3d.shapes.icosphere(5)
    query = punctual3d.Query(large, large, mode="all")
    busy = threading.Thread(target=query.run)
    errors = []
    busy.start()
    while busy.is_alive():
        try:
            query.predict()
        except RuntimeError as error:
            errors.append(str(error))
    busy.join()
    assert errors and all("borrowed" in error for error in errors)


def test_batches_tell_how_far_they_are():
    ball, told = punctual3d.shapes.icosphere(5), []
    poses = random_poses(3_000, 2.0)
    for threads in (1, 2):
        for ask in (punctual3d.collide_batch, punctual3d.distance_batch):
            del told[:]
            quiet = ask(ball, ball, poses, threads=threads)
            assert ask(ball, ball, poses, threads=threads, progress=lambda *at: told.append(at)) == quiet
            done = [done for done, _ in told]
            assert done == sorted(done) and told[-1] == (len(poses), len(poses))

    def stop(done, total):
        raise StopIteration(f"{done} of {total}")

    with pytest.raises(StopIteration, match="of 3000"):
        punctual3d.collide_batch(ball, ball, poses, progress=stop)
    punctual3d.collide_batch(ball, ball, [], progress=lambda *at: told.append(at))
    assert told[-1] == (0, 0)

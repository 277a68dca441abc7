// Mouse, fingers and keys that move a camera; `changed` is called when they did, `clicked` where a pointer did not move.

function control(canvas, camera, changed, clicked) {
  let start;
  const pointers = new Map();
  const middle = () => {
    const all = [...pointers.values()];
    return [0, 1].map(i => all.reduce((sum, at) => sum + at[i], 0) / all.length);
  };
  const spread = () => {
    const [p, q] = pointers.values();
    return q ? Math.hypot(p[0] - q[0], p[1] - q[1]) : 1;
  };

  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    start = pointers.size === 1 && event.button === 0 ? [event.clientX, event.clientY] : undefined;
  });
  canvas.addEventListener("pointermove", event => {
    if (!pointers.has(event.pointerId)) return;
    const [before, apart] = [middle(), spread()];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const [right, down] = middle().map((value, i) => (value - before[i]) / canvas.clientHeight);
    if (pointers.size > 1 || event.shiftKey || event.buttons & 6) {
      camera.move(right, -down);
      camera.approach(apart / Math.max(spread(), 1));
    } else {
      camera.turn(4 * right, 4 * down);
    }
    changed();
  });
  canvas.addEventListener("pointerup", ({ clientX, clientY }) => {
    if (start && Math.hypot(clientX - start[0], clientY - start[1]) < 5) clicked(clientX, clientY);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, event => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    camera.approach(Math.exp(Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 100) * 0.002));
    changed();
  }, { passive: false });

  const keys = {
    ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
  };
  // Wherever the focus is; only what uses arrows itself keeps them.
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const arrow = keys[event.key];
    if (arrow && event.target.matches?.("input[type=range], select")) return;
    if (arrow && event.shiftKey) camera.move(0.05 * arrow[0], -0.05 * arrow[1]);
    else if (arrow) camera.turn(0.1 * arrow[0], 0.1 * arrow[1]);
    else if (event.key === "+" || event.key === "=") camera.approach(1 / 1.15);
    else if (event.key === "-") camera.approach(1.15);
    else return;
    event.preventDefault();
    changed();
  });
}

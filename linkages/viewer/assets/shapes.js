/** Shapes of linkages/plots/mechanism/shapes.py on a canvas, or on paper that takes the same calls. */
function drawShapes(ctx, shapes, scene, camera, colours, point) {
  ctx.lineCap = ctx.lineJoin = "round";
  for (const shape of shapes) {
    if (shape.kind === "word") continue;
    const angle = scene.direction(shape.direction);
    if (angle === null) continue;
    const there = shape.kind === "line" ? followLine(ctx, shape, scene, angle, camera, point)
      : followDisc(ctx, shape, scene, angle, camera, point);
    if (there) paint(ctx, shape, colours, point);
  }
  ctx.setLineDash([]);
}

function followLine(ctx, shape, scene, angle, camera, point) {
  ctx.beginPath();
  for (const stroke of shape.strokes) {
    let first = true;
    for (const anchor of stroke) {
      const at = scene.anchor(anchor, angle, camera, point);
      if (!at) return false;
      if (first) ctx.moveTo(...at); else ctx.lineTo(...at);
      first = false;
    }
    if (shape.closed) ctx.closePath();
  }
  return true;
}

function followDisc(ctx, shape, scene, angle, camera, point) {
  const at = scene.anchor(shape.centre, angle, camera, point);
  if (!at) return false;
  ctx.beginPath();
  ctx.arc(at[0], at[1], shape.metres * camera.scale + shape.points * point, 0, 2 * Math.PI);
  return true;
}

function paint(ctx, shape, colours, point) {
  if (shape.casing) {
    ctx.setLineDash([]);
    ctx.strokeStyle = colours.paper;
    ctx.lineWidth = (shape.width + 2 * shape.casing) * point;
    ctx.stroke();
  }
  if (shape.fill) {
    ctx.globalAlpha = shape.opacity;
    ctx.fillStyle = colours[shape.fill];
    ctx.fill();
    ctx.globalAlpha = 1;
  }
  if (shape.width) {
    ctx.setLineDash(shape.dashes.map((length) => length * point));
    ctx.strokeStyle = colours[shape.role];
    ctx.lineWidth = shape.width * point;
    ctx.stroke();
  }
}

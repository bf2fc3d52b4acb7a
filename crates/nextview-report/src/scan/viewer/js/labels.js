// Texts over the drawing: numbers of cameras, the directions of the axes, the scale.
function labelLayer(canvas) {
  const ctx = canvas.getContext("2d");
  const text = (words, x, y, ratio, ink, paper, weight = 600) => {
    ctx.font = `${weight} ${12 * ratio}px system-ui, sans-serif`;
    ctx.lineJoin = "round";
    ctx.strokeStyle = paper;
    ctx.lineWidth = 3 * ratio;
    ctx.strokeText(words, x, y);
    ctx.fillStyle = ink;
    ctx.fillText(words, x, y);
  };
  const camera = (words, place, scene, view, ink, paper) => {
    const at = view.project(place);
    if (at.depth < 0) return;
    // Fainter behind the object.
    const center = view.project(scene.center);
    const reach = view.focal * scene.radius / Math.max(center.depth, 1e-6);
    const isBehind = at.depth > center.depth && Math.hypot(at.x - center.x, at.y - center.y) < 0.8 * reach;
    ctx.globalAlpha = isBehind ? 0.3 : 1;
    ctx.font = `600 ${12 * view.ratio}px system-ui, sans-serif`;
    const room = view.size[0] - ctx.measureText(words).width - 4 * view.ratio;
    const isSeen = at.x > 0 && at.x < view.size[0];
    text(words, isSeen ? Math.min(at.x + 5 * view.ratio, room) : at.x, at.y - 5 * view.ratio, view.ratio, ink, paper);
    ctx.globalAlpha = 1;
  };
  const axes = (view, ink, paper) => {
    const { ratio, rows, size } = view;
    const origin = [34 * ratio, size[1] - 34 * ratio];
    ["x", "y", "z"].forEach((name, k) => {
      const tip = (reach) => [origin[0] + reach * ratio * rows[0][k], origin[1] - reach * ratio * rows[1][k]];
      ctx.beginPath();
      ctx.moveTo(...origin);
      ctx.lineTo(...tip(19));
      ctx.strokeStyle = ink;
      ctx.lineWidth = 1.4 * ratio;
      ctx.stroke();
      const [x, y] = tip(26);
      text(name, x - 3 * ratio, y + 4 * ratio, ratio, ink, paper, 400);
    });
  };
  return (scene, view, { shown, cameras, ink, paper }) => {
    [canvas.width, canvas.height] = view.size;
    axes(view, ink, paper);
    text(`grid ${lengthText(scene.gridStep)}`, 66 * view.ratio, view.size[1] - 10 * view.ratio, view.ratio, ink, paper, 400);
    const number = (v, i) => camera(String(i + 1), v.position, scene, view, ink, paper);
    if (cameras) scene.views.slice(0, shown).forEach(number);
    if (scene.next) {
      const { expected } = scene.next;
      const gain = expected === null ? "" : `: ${Math.round(expected)} voxels expected`;
      camera(`next${gain}`, scene.next.position, scene, view, ink, paper);
    }
    if (scene.current) camera("camera", scene.current.position, scene, view, ink, paper);
  };
}

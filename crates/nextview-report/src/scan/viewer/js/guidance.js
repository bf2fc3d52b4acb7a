// The way from the camera in the hand to the proposed view: an arrow in the picture of the camera.
function showGuidance(guidance) {
  byId("guidance").hidden = !guidance;
  if (!guidance) return;
  const { arrow_m: [right, down, forward], turn_deg: [turnRight, turnDown], distance_m: away, reached } = guidance;
  byId("guidance").classList.toggle("reached", reached);
  // Short where the way leads ahead.
  const size = Math.max(0.3, Math.hypot(right, down) / Math.max(away, 1e-6));
  byId("arrow").setAttribute("transform", `rotate(${Math.atan2(right, -down) * 180 / Math.PI}) scale(${size})`);
  const part = (value, least, text, positive, negative) =>
    Math.abs(value) < least ? [] : [`${text(Math.abs(value))} ${value > 0 ? positive : negative}`];
  const go = (value, ...directions) => part(value, 0.005, lengthText, ...directions);
  const turn = (value, ...directions) => part(value, 1, (degrees) => `${Math.round(degrees)}°`, ...directions);
  const way = [...go(right, "right", "left"), ...go(down, "down", "up"), ...go(forward, "forward", "back")];
  const turns = [...turn(turnRight, "right", "left"), ...turn(turnDown, "down", "up")];
  const words = [way.length ? `Go ${way.join(", ")}` : "Stay in place", ...(turns.length ? [`turn ${turns.join(", ")}`] : [])];
  byId("guidance-text").textContent = reached ? "View reached: hold still." : `${words.join("; ")}.`;
}

// A camera in this pose, with the lens of the scan.
function cameraAt(rows, lens) {
  const turned = (point) => rows.slice(0, 3).map((row) => dot(row, point));
  return { position: rows.slice(0, 3).map((row) => row[3]), corners: lens.map(turned) };
}

function showTracking({ lost, remedy }) {
  byId("tracking").hidden = !lost;
  byId("tracking").textContent = lost ? `The position of the camera is unknown: ${remedy || "move it back to its last known position"}.` : "";
  if (lost) showGuidance(null);
}

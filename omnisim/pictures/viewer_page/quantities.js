// What the chart may show: title with unit, and its curves.

// A curve: label, values row by row; where the file has them a target to follow, and the lowest and highest values
// since the row before, between which it went.

export function quantities(motion, wheels) {
  const size = (path) => sizes(motion.column(path, 0), motion.column(path, 1));
  const has = (path) => path in motion.arrays;
  const body = (label, path, values = motion.column(path)) => [{ label, values, ...extremes(path, values) }];

  function extremes(path, values) {
    const [low, high] = [`interval_min/${path}`, `interval_max/${path}`];
    if (!has(high)) return {};
    const lowest = has(low) ? motion.column(low) : values.map((value, i) => Math.min(value, values[i - 1] ?? value));
    return { low: lowest, high: motion.column(high) };
  }

  // Of the wheels that have a dataset.
  function each(name, read = motion.column.bind(motion)) {
    return wheels.flatMap(({ name: label }) => {
      const [path, target] = [`wheels/${label}/${name}`, `wheels/${label}/target_rate`];
      if (!has(path)) return [];
      const values = read(path);
      const followed = name === "spin_rate" && has(target) ? { target: motion.column(target) } : {};
      return [{ label, values, ...followed, ...extremes(path, values) }];
    });
  }

  // Each once, for both of its wheels.
  function rockers() {
    const first = new Map(wheels.filter(({ rocker }) => rocker).map(({ rocker, name }) => [rocker.name, name]));
    return [...first].flatMap(([label, wheel]) => body(label, `wheels/${wheel}/rocker_angle`));
  }

  const all = {
    "speed, m/s": body("speed", "body/velocity", size("body/velocity")),
    "height, m": has("body/orientation") ? body("height", "body/position", motion.column("body/position", 2)) : [],
    "roll and pitch, rad": has("body/roll") ? [...body("roll", "body/roll"), ...body("pitch", "body/pitch")] : [],
    "yaw rate, rad/s": body("yaw rate", "body/yaw_rate"),
    "spin rate, rad/s": each("spin_rate"),
    "drive torque, N m": each("drive_torque"),
    "drive power, W": each("drive_power"),
    "voltage, V": each("voltage"),
    "current, A": each("current"),
    "electrical power, W": each("electrical_power"),
    "slip, m/s": each("slip_velocity", size),
    "suspension travel, m": each("suspension_travel"),
    "angle of the rocker, rad": rockers(),
    "normal force, N": each("normal_force"),
    "friction force, N": each("friction_force", size),
    "odometry error, m": has("odometry/position_error")
      ? body("position", "odometry/position_error", size("odometry/position_error"))
      : [],
    "odometry error, rad": has("odometry/yaw_error") ? body("yaw", "odometry/yaw_error") : [],
    "energy balance, J": body("balance", "energy/balance"),
  };
  return Object.fromEntries(Object.entries(all).filter(([, curves]) => curves.length));
}

function sizes(...columns) {
  return columns[0].map((_, row) => Math.hypot(...columns.map((column) => column[row])));
}

/** All scenarios for Node and browsers. */

import type { Scenarios } from "../world.js";
import { batches } from "./batches.js";
import { jobs } from "./jobs.js";
import { failures } from "./failures.js";
import { streams } from "./streams.js";

export const scenarios: Scenarios = { ...jobs, ...batches, ...streams, ...failures };

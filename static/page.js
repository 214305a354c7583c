// The page's own script: locks the camera, names keys and clicks, and lays scale, legend and timeline over the map.

import { start as startCamera } from "./camera.js";
import { open } from "./channel.js";
import { start as startKeys } from "./keys.js";
import { start as startLegend } from "./legend.js";
import { start as startOverlay } from "./overlay.js";
import { start as startTimeline } from "./timeline.js";

open();
startOverlay();
startLegend();
startTimeline();
startCamera();
startKeys();

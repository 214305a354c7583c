// The page's own script: it locks the camera, names keys and clicks, and adds grid, scale, legend and timeline.

import { start as startCamera } from "./camera.js";
import { open } from "./channel.js";
import { start as startGrid } from "./grid.js";
import { start as startKeys } from "./keys.js";
import { start as startLegend } from "./legend.js";
import { start as startOverlay } from "./overlay.js";
import { start as startRows } from "./rows.js";
import { start as startTimeline } from "./timeline.js";
import { start as startZoom } from "./zoom.js";

open();
startGrid();
startOverlay();
startLegend();
startTimeline();
startZoom();
startCamera();
startKeys();
startRows();

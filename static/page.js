// The page's own script: it locks the camera, turns keys into actions, and adds grid, scale, legend, timeline,
// palette and help sheet.

import { start as startActions } from "./actions.js";
import { start as startBox } from "./box.js";
import { start as startCamera } from "./camera.js";
import { open } from "./channel.js";
import { start as startFrames } from "./frames.js";
import { start as startGrid } from "./grid.js";
import { start as startKeys } from "./keys.js";
import { start as startLegend } from "./legend.js";
import { start as startOverlay } from "./overlay.js";
import { start as startPalette } from "./palette.js";
import { start as startQuestions } from "./question.js";
import { start as startRows } from "./rows.js";
import { start as startSheet } from "./sheet.js";
import { start as startStage } from "./stage.js";
import { start as startTabs } from "./tabs.js";
import { start as startTimeline } from "./timeline.js";
import { start as startTour } from "./tour.js";
import { start as startVisit } from "./visit.js";
import { start as startZoom } from "./zoom.js";

open();
startFrames();
startGrid();
startOverlay();
startLegend();
startTimeline();
startZoom();
startCamera();
startPalette();
startQuestions();
startSheet();
startTabs();
startStage();
startVisit();
startTour();
startActions();
startBox();
startKeys();
startRows();

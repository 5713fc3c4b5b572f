// Entry point of the worker that startWorker() starts. This file alone does something when it is imported.
import { load } from './index.js';
import { serve, type WorkerScope } from './worker/serve.js';

serve(self as unknown as WorkerScope, load());

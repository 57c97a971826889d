# SPDX-License-Identifier: MIT
"""Shape and control by torch.optim.Adam: shares are a softmax, the amplitude is a sigmoid: no bounds in the way."""
import torch

import fish
from diffaqua.torch import RolloutLoss

options = fish.arguments(__doc__, iterations=20)
rollout, w0, theta0 = fish.rollout(options.steps)
loss_of = RolloutLoss(rollout.simulator, rollout.controller, options.steps, rollout.loss)
log = fish.Log(options.tensorboard)

logits = torch.log(torch.tensor(w0)).requires_grad_()
swing = torch.logit(torch.tensor(theta0[0])).requires_grad_()
omega = torch.tensor(theta0[1]).requires_grad_()
phase = torch.tensor(theta0[2]).requires_grad_()
adam = torch.optim.Adam([{"params": [logits, swing, phase], "lr": 0.2}, {"params": [omega], "lr": 0.5}])
for _ in range(options.iterations):
    adam.zero_grad()
    w, theta = torch.softmax(logits, 0), torch.stack([torch.sigmoid(swing), omega, phase])
    loss = loss_of(w, theta)
    loss.backward()
    log(loss.item(), w.detach().numpy(), theta.detach().numpy())
    adam.step()
log.close()

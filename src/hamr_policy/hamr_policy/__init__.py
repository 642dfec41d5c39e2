"""Environments, rewards, PPO training, export and transfer figures of walking and turning policies; policy node."""
